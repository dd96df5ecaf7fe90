"""Any bytes as a plan: exit code 0, 1 or 2, a sentence, and nothing else changes. The runs are left out."""

import pytest
from hostile_files import changed_toml
from hostile_run import MANY, Surroundings, fault, run, tried
from hypothesis import given

import pyident as pi
from pyident.sweep import cost
from pyident.sweep.store import StudyError

PLAN = """model = "four_link"
experiment = "identification"
design = "grid"
runs = 4
seed = 1
metrics = ["tip_error"]
[parameters]
"joint1.coulomb" = [20.0, 40.0]
"joint2.*" = 0.1
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """In which a good plan gets as far as its first run."""

    def begun(*_, **__):
        raise StudyError("the runs begin here")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(pi, "parameter_study", begun)
    monkeypatch.setattr(cost, "one_run", lambda plan: 0.01)
    return tmp_path


@MANY
@given(content=changed_toml(PLAN))
def test_plans(content, folder):
    done = tried("plans", folder, {"plan.toml": content}, "sweep", "plan.toml", "-o", "out")
    assert done.exit_code == 2


def test_a_plan_of_ten_million_runs_asks_first(folder):
    text = PLAN.replace("runs = 4", "runs = 10_000_000").replace('"grid"', '"latin_hypercube"')
    (folder / "plan.toml").write_text(text)
    before = Surroundings(folder)
    done = run("sweep", "plan.toml", "-o", "out", "--workers", "2")
    assert fault(done) is None
    assert done.exit_code == 2
    assert "10000000 runs would take about 14 hours" in " ".join(
        done.output.split()
    )  # 1e7 of 10 ms, 2 at once
    assert "not begun" in done.output
    assert before.changes() == []
