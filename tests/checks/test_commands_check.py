"""Every command and every verb refuses a grossly wrong log, and carries what is doubtful."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import pyident as pi
from pyident.cli.main import main
from pyident.logs.log import Log, LogError, write_log


@pytest.fixture(scope="module")
def negated(identification_log):
    names = [name for name in identification_log.names if name.endswith(".tau")]
    return Log(identification_log.frame.assign(**{n: -identification_log.frame[n] for n in names}), "negated")


@pytest.mark.parametrize(
    "words",
    [["identify", "four_link"], ["compare", "four_link"], ["diagnose", "four_link"],
     ["add", "four_link", "stribeck", "--joint", "2"]],
    ids=lambda words: words[0],
)  # fmt: skip
def test_commands_refuse_negated_torques(words, negated, tmp_path):
    write_log(negated, tmp_path / "negated.csv")
    extra = ["-o", str(tmp_path / "new.toml")] if words[0] in ("identify", "add") else []
    done = CliRunner().invoke(main, [*words, str(tmp_path / "negated.csv"), *extra])
    assert done.exit_code == 2, done.output
    assert "has the wrong sign against joint" in done.output
    assert "--force" in done.output
    assert not (tmp_path / "new.toml").exists()


def test_force_takes_the_log_and_says_so(negated, tmp_path):
    write_log(negated, tmp_path / "negated.csv")
    words = ["identify", "four_link", tmp_path / "negated.csv", "--force", "--json", tmp_path / "found.json"]
    done = CliRunner().invoke(main, [str(w) for w in words])
    assert done.exit_code == 0, done.output
    notes = json.loads((tmp_path / "found.json").read_text())["notes"]
    assert any("has the wrong sign" in note for note in notes)
    assert "note: " in done.output


def test_the_api_refuses_and_warns_alike(four_link, negated, identification_log):
    for verb in (pi.identify, pi.compare, pi.diagnose):
        with pytest.raises(LogError, match="force=True"):
            verb(four_link, negated)
    with pytest.raises(LogError, match="force=True"):
        pi.add_effect(four_link, "stribeck", 2, negated)
    frame = identification_log.frame.copy()
    frame["joint2.tau"] = np.minimum(frame["joint2.tau"], frame["joint2.tau"].quantile(0.97))
    found = pi.identify(four_link, frame)
    assert any("runs into a limit" in note for note in found.notes)
