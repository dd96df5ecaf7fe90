"""What a server leaves to the next one: results of exactly the inputs that they are of."""

import os
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import pytest
from outcomes import DIAGNOSIS

from pyident.extension.waterfall import Step
from pyident.workbench.bench import Bench
from pyident.workbench.jobs import Job
from pyident.workbench.kept import keep, kept
from pyident.workbench.project import Version, open_project
from pyident.workbench.work import Fitted, Outcome

OUTCOME = Outcome("", (Step("torque", "N.m", 2.0, 1.0, 0.5, "fitted"),), (0.5, 0.4))
RESULTS = {
    "check": {"a.parquet": ["1000 samples"]},
    "diagnose": replace(DIAGNOSIS, remaining=float("nan"), band=50.0),
    "add": OUTCOME,
    "identify": Fitted("61 of 76 are determined", "a table"),
}


@pytest.fixture
def folder(tmp_path):
    for name in ("a.parquet", "robot.toml", "better.toml"):
        (tmp_path / name).write_text("")
    return tmp_path


def reopened(folder) -> Bench:
    return Bench(open_project(folder))


@pytest.mark.parametrize("what", RESULTS)
def test_a_result_is_read_as_it_was_written(folder, what):
    inputs = reopened(folder).inputs
    keep(folder, what, inputs, RESULTS[what])
    assert repr(kept(folder, what, inputs)) == repr(RESULTS[what])  # nan is not equal to itself


def test_the_next_server_has_the_verdict(folder):
    bench = reopened(folder)
    job = SimpleNamespace(running=False, state="done", result=DIAGNOSIS, title="diagnosing")
    bench._asked["diagnose"], bench.jobs["diagnose"] = bench.inputs, cast(Job, job)
    bench.collect()
    assert repr(reopened(folder).result("diagnose")) == repr(DIAGNOSIS)


def test_a_law_that_was_added_is_told_after_a_restart_and_its_version_stays_open(folder):
    bench = reopened(folder)
    bench._hold("check", bench.inputs, RESULTS["check"])
    bench._hold("add", bench.inputs, OUTCOME)
    bench._take(Version("better.toml", "robot.toml", "stribeck at joint 1"))
    again = reopened(folder)
    assert again.last_added == OUTCOME
    assert again.sound


@pytest.mark.parametrize("name", ["a.parquet", "robot.toml"])
def test_a_file_that_changed_has_no_result(folder, name):
    bench = reopened(folder)
    bench._hold("diagnose", bench.inputs, DIAGNOSIS)
    os.utime(folder / name, (1, 1))
    assert reopened(folder).result("diagnose") is None


def test_a_file_that_cannot_be_read_is_no_result(folder):
    bench = reopened(folder)
    bench._hold("diagnose", bench.inputs, DIAGNOSIS)
    (file,) = (folder / "results" / "kept").iterdir()
    file.write_text('{"verdict": "certainly"}')
    assert reopened(folder).result("diagnose") is None
