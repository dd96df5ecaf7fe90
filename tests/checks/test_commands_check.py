"""Every command and every verb refuses a grossly wrong log, and carries what is doubtful."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from two_link_logs import TWO_LINK, loaded, made_log, two_link

import pyident as pi
from pyident.cli.main import main
from pyident.logs.log import Log, LogError, write_log


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    with loaded(two_link(), tmp_path_factory.mktemp("fmu")) as fmu:
        return made_log(fmu, two_link(), 1)


@pytest.fixture(scope="module")
def negated(sound):
    names = [name for name in sound.names if name.endswith(".tau")]
    return Log(sound.frame.assign(**{n: -sound.frame[n] for n in names}), "negated")


@pytest.mark.parametrize(
    "words",
    [["identify", TWO_LINK], ["compare", TWO_LINK], ["diagnose", TWO_LINK],
     ["add", TWO_LINK, "stribeck", "--joint", "2"]],
    ids=lambda words: words[0],
)  # fmt: skip
def test_commands_refuse_negated_torques(words, negated, tmp_path):
    write_log(negated, tmp_path / "negated.csv")
    extra = ["-o", str(tmp_path / "new.toml")] if words[0] in ("identify", "add") else []
    done = CliRunner().invoke(main, [*map(str, words), str(tmp_path / "negated.csv"), *extra])
    assert done.exit_code == 2, done.output
    assert "has the wrong sign against joint" in done.output
    assert "--force" in done.output
    assert not (tmp_path / "new.toml").exists()


def test_force_takes_the_log_and_says_so(negated, tmp_path):
    write_log(negated, tmp_path / "negated.csv")
    words = ["identify", TWO_LINK, tmp_path / "negated.csv", "--force", "--json", tmp_path / "found.json"]
    done = CliRunner().invoke(main, [str(w) for w in words])
    assert done.exit_code == 0, done.output
    notes = json.loads((tmp_path / "found.json").read_text())["notes"]
    assert any("has the wrong sign" in note for note in notes)
    assert "note: " in done.output


def test_the_api_refuses_and_warns_alike(sound, negated):
    for verb in (pi.identify, pi.compare, pi.diagnose):
        with pytest.raises(LogError, match="force=True"):
            verb(two_link(), negated)
    with pytest.raises(LogError, match="force=True"):
        pi.add_effect(two_link(), "stribeck", 2, negated)
    frame = sound.frame.copy()
    frame["joint2.tau"] = np.minimum(frame["joint2.tau"], frame["joint2.tau"].quantile(0.97))
    found = pi.identify(two_link(), frame)
    assert any("runs into a limit" in note for note in found.notes)
