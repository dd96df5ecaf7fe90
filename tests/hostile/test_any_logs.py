"""Any bytes as a log or its mapping: exit code 0, 1 or 2, a sentence, and nothing else changes."""

from pathlib import Path

import pytest
from hostile_files import changed_toml, mats, parquets, tables
from hostile_run import MANY, cleared, tried
from hypothesis import given

ROBOT = (Path(__file__).parents[1] / "robots" / "two_link.toml").read_bytes()
MAPPING = """joints = 2
time = { source = "t", unit = "ms" }
[signals."joint{k}.e"]
source = "q{k}"
unit = "deg"
offset = [0.0, 90.0]
delay = 0.001
[signals."joint{k}.tau"]
source = "tau{k}"
sign = -1
"""
NAMES = ["time", *(f"joint{k}.{s}" for k in (1, 2) for s in ("e", "eps[1]", "eps[2]", "eps[3]", "tau"))]
PLAIN = ["t", "q1", "q2", "tau1", "tau2"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@MANY
@given(content=tables(NAMES))
def test_csv(content, folder):
    identified(folder, "log.csv", content)


@MANY
@given(content=parquets(NAMES))
def test_parquet(content, folder):
    identified(folder, "log.parquet", content)


def identified(folder, name, content):
    """A dozen rows identify no robot: the log is refused, whatever stands in it."""
    words = ("identify", "arm.toml", name, "-o", "out.toml")
    done = tried("logs to identify from", folder, {"arm.toml": ROBOT, name: content}, *words)
    assert done.exit_code == 2
    assert not (folder / "out.toml").exists()


@MANY
@given(content=mats(PLAIN))
def test_mat(content, folder):
    files = {"map.toml": MAPPING.encode(), "log.mat": content}
    imported(folder, "MAT files", files, "log.mat")


@MANY
@given(mapping=changed_toml(MAPPING), content=tables(PLAIN))
def test_mappings(mapping, content, folder):
    imported(folder, "mappings", {"map.toml": mapping, "log.csv": content}, "log.csv")


def imported(folder, family, files, name):
    words = ("log", "import", name, "--mapping", "map.toml", "-o", "out.csv")
    done = tried(family, folder, files, *words)
    assert (folder / "out.csv").exists() == (done.exit_code != 2)
    cleared(folder)


@MANY
@given(content=tables(PLAIN) | tables(NAMES))
def test_inspected(content, folder):
    words = ("log", "inspect", "log.csv", "--json", "out.json")
    done = tried("logs to inspect", folder, {"log.csv": content}, *words)
    assert (folder / "out.json").exists() == (done.exit_code != 2)
    cleared(folder)


@MANY
@given(content=parquets(PLAIN) | mats(PLAIN))
def test_inspected_binaries(content, folder):
    for name in ("log.parquet", "log.mat"):  # one of them is another format under a wrong ending
        done = tried("logs to inspect", folder, {name: content}, "log", "inspect", name)
        assert (done.exit_code == 1) == ("\n? " in done.output)  # questions are left
        (folder / name).unlink()
