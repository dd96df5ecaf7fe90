"""A foreign FMU may do what it likes: the command ends in one sentence, and nothing is left of it."""

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import pandas as pd
import pytest
from hostile_run import Surroundings, counted, run

SOURCE = Path(__file__).parent / "foreign_fmu.c"
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="foreign" guid="{guid}">
<CoSimulation modelIdentifier="foreign"/>
<ModelVariables>
<ScalarVariable name="joint1.r" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="joint1.tau_ff" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="joint1.e" valueReference="2" causality="output"><Real/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="3"/></Outputs></ModelStructure>
</fmiModelDescription>
"""

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc compiles the foreign FMU")


def fmu(folder, fault="FINE", guid="right", defines=(), binary=None):
    """An FMU file of the fault; `binary`: its bytes instead of compiled ones, empty for none."""
    library = folder / "foreign.so"
    if binary is None:
        flags = ["-w", "-shared", "-fPIC", f"-DFAULT={fault}", *(f"-D{name}" for name in defines)]
        subprocess.run(["gcc", *flags, str(SOURCE), "-o", str(library)], check=True)
        binary = library.read_bytes()
    path = folder / "foreign.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION.format(guid=guid))
        if binary:
            archive.writestr("binaries/linux64/foreign.so", binary)
    library.unlink(missing_ok=True)
    return path


@pytest.fixture
def references(tmp_path):
    pd.DataFrame({"time": [0.0, 0.01, 0.02], "joint1.r": [0.0, 0.1, 0.2]}).to_csv(
        tmp_path / "r.csv", index=False
    )
    return tmp_path / "r.csv"


def simulated(path, references, *more):
    output = references.parent / "log.csv"
    counted("foreign FMUs")
    return run("simulate", path, "--experiment", references, "-o", output, *more), output


def test_a_foreign_fmu_that_behaves(tmp_path, references):
    done, output = simulated(fmu(tmp_path), references)
    assert done.exit_code == 0, done.output
    assert list(pd.read_csv(output)["joint1.e"]) == [0.0, 0.0, 0.1]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"fault": "CRASH"}, "the FMU crashed (signal 11)"),
        ({"fault": "HANG"}, "the FMU did not respond for 4 s"),
        ({"fault": "EXIT"}, "the FMU ended its process by itself (exit code 0)"),
        ({"fault": "NOT_A_NUMBER"}, "the FMU's joint1.e is not a finite number at 0.01 s"),
        ({"fault": "INFINITE"}, "the FMU's joint1.e is not a finite number at 0.01 s"),
        ({"fault": "NULL_INSTANCE"}, "instantiate"),
        ({"guid": "wrong"}, "instantiate"),
        ({"defines": ("ABORT_AT_LOAD",)}, "the FMU crashed (signal 6)"),
        ({"fault": "ERROR_STATUS"}, "the FMU failed"),
        ({"defines": ("WITHOUT_STEP",)}, "fmi2DoStep"),
        ({"binary": b""}, "shared library"),
        ({"binary": b"MZ this is of another platform"}, "foreign.so"),
    ],
)
def test_a_foreign_fmu_that_does_not(change, words, tmp_path, references):
    path = fmu(tmp_path, **change)
    before = Surroundings(tmp_path)
    done, output = simulated(path, references, "--time-limit", "4" if change.get("fault") == "HANG" else "60")
    assert done.exit_code == 2, done.output
    assert words in done.output
    assert len(done.output.strip().splitlines()) == 1
    assert not output.exists()
    assert before.changes() == []


@pytest.mark.parametrize(
    "damage", ["empty", "text", "cut", "flipped", "encrypted", "folder", "no description"]
)
def test_a_damaged_file(damage, tmp_path, references):
    path = fmu(tmp_path, binary=os.urandom(3000))
    content = path.read_bytes()
    if damage == "folder":
        path.unlink()
        path.mkdir()
    elif damage == "no description":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("readme.txt", "no FMU")
    else:
        path.write_bytes(
            {
                "empty": b"",
                "text": b"this is no archive",
                "cut": content[:-200],
                "flipped": content[:40] + bytes(255 - b for b in content[40:90]) + content[90:],
                "encrypted": content.replace(b"PK\1\2\x14\x03\x14\0\0\0", b"PK\1\2\x14\x03\x14\0\1\0"),
            }[damage]
        )
    before = Surroundings(tmp_path)
    done, output = simulated(path, references)
    assert done.exit_code == 2, done.output
    assert "foreign.fmu" in done.output
    assert len(done.output.strip().splitlines()) == 1
    assert not output.exists()
    assert before.changes() == []


def test_no_module_beside_the_logs_is_run(tmp_path, references, monkeypatch):
    """Python itself looks for modules first where a process is started."""
    path = fmu(tmp_path)
    for name in ("json", "random", "numpy", "flexfmu"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'a').write('{name}')\n")
    monkeypatch.chdir(tmp_path)
    done, _ = simulated(path, references)
    assert done.exit_code == 0, done.output
    assert not (tmp_path / "ran").exists()
