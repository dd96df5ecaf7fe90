"""What may be written under which name: nothing of somebody else's is replaced, no input is lost."""

import json
import os
from pathlib import Path

import pandas as pd
import pytest
from one_joint import one_joint, swing

import pyident as pi
from flexmodels.files.robot_file import save_robot
from pyident.cli.common import outputs
from pyident.cli.common.outputs import OutputError, check_output
from pyident.logs.log import write_log

FOREIGN = b"somebody's own notes\n"


@pytest.fixture(scope="module")
def ours(tmp_path_factory) -> dict[str, Path]:
    """A file of every kind, as the commands write them."""
    folder = tmp_path_factory.mktemp("ours")
    log = pi.Log(pd.DataFrame({"time": [0.0, 0.004], "joint1.e": [0.0, 1.0]}))
    made = {
        "ROBOT": save_robot(one_joint(), folder / "robot.toml") or folder / "robot.toml",
        "FMU": pi.export_fmu(one_joint(), folder / "arm.mo"),
        "JSON": folder / "result.json",
        "MAPPING": folder / "mapping.toml",
    }
    for ending in (".csv", ".parquet", ".mat"):
        write_log(log, folder / f"log{ending}")
        made[f"LOG{ending}"] = folder / f"log{ending}"
    for ending in (".csv", ".json", ".yaml"):
        made[f"TRAJECTORY{ending}"] = pi.export_plan(swing(), one_joint(), folder / f"plan{ending}")
    (folder / "result.json").write_text(json.dumps({"a": 1}))
    (folder / "mapping.toml").write_text('[signals."joint1.e"]\nsource = "q"\n')
    for ending, text in ((".urdf", "<robot/>"), (".xml", "<mujoco/>"), (".json", "{}")):
        made[f"MODEL{ending}"] = folder / f"model{ending}"
        made[f"MODEL{ending}"].write_text(text)
    return made


def test_ours_may_be_written_again_and_somebody_elses_not(ours, tmp_path):
    for key, path in ours.items():
        kind = getattr(outputs, key.partition(".")[0])
        check_output(str(path), kind, [], overwrite=False)
        foreign = tmp_path / f"foreign{path.suffix}"
        foreign.write_bytes(FOREIGN)
        with pytest.raises(OutputError, match=f"exists and is no {kind.what} of ours"):
            check_output(str(foreign), kind, [], overwrite=False)
        check_output(str(foreign), kind, [], overwrite=True)


def test_an_empty_file_and_a_new_name_are_free(tmp_path):
    (tmp_path / "empty.toml").write_bytes(b"")
    for name in ("empty.toml", "new.toml"):
        check_output(str(tmp_path / name), outputs.ROBOT, [], overwrite=False)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        (" ", "an output has an empty name; call it, say, out.toml"),
        ("folder", "is a folder; name a file in it, such as"),
        ("nowhere/robot.toml", "there is no such folder; make it first"),
        ("robot.txt", "a robot file must end in .toml"),
        ("input.toml", "is an input .* which would be lost; write to another file"),
        ("recording/input.toml", "is an input .* which would be lost"),
    ],
)
def test_a_name_is_refused(name, sentence, tmp_path):
    for folder in ("folder", "recording"):
        (tmp_path / folder).mkdir()
    inputs = [tmp_path / "input.toml", tmp_path / "recording"]
    for file in (inputs[0], inputs[1] / "input.toml"):
        save_robot(one_joint(), file)
    given = name if not name.strip() else str(tmp_path / name)
    with pytest.raises(OutputError, match=sentence):
        check_output(given, outputs.ROBOT, inputs, overwrite=True)


@pytest.mark.skipif(os.name != "posix", reason="has no pipes by name")
def test_a_pipe_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(OutputError, match="is a device or a pipe"):
        check_output(str(tmp_path / "pipe.toml"), outputs.ROBOT, [], overwrite=True)
