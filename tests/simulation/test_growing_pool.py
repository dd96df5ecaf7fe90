"""Where simulations are made: here while they are few, in other processes when they are many."""

import os

import pandas as pd
import pytest
from one_joint import one_joint, swing

from pyident.simulation.fmu_runs import FmuRuns, runs_here
from pyident.simulation.processes import growing_pool
from pyident.simulation.processes.dask_cluster import WorkersError, scheduler_configured


def process_of(fmu):
    return os.getpid()


@pytest.fixture
def sets():
    return [{"joint1.viscous": v} for v in (1.0, 2.0)]


def test_short_work_starts_no_process(sets):
    with FmuRuns(one_joint()) as runs:
        list(runs(swing(), sets))
        assert runs.submit(process_of).result() == os.getpid()


def test_what_goes_on_goes_to_other_processes_and_is_the_same(sets, monkeypatch):
    monkeypatch.setattr(growing_pool, "_START", 0.0)
    with FmuRuns(one_joint()) as runs:
        there = list(runs(swing(), sets))
        assert runs.submit(process_of).result() != os.getpid()
    with runs_here(one_joint()) as runs:
        here = list(runs(swing(), sets))
    for a, b in zip(here, there, strict=True):
        pd.testing.assert_frame_equal(a, b)


def test_a_task_that_fails_here_fails_as_it_would_there():
    with FmuRuns(one_joint()) as runs:
        job = runs.submit(_fails)
        with pytest.raises(ZeroDivisionError):
            job.result()
        assert runs.submit(process_of).result() == os.getpid()


def test_a_cluster_that_is_configured_gets_all_of_it(monkeypatch):
    monkeypatch.setattr("pyident.simulation.processes.dask_cluster._CONNECT_SECONDS", 1)
    with scheduler_configured("tcp://127.0.0.1:9"), pytest.raises(WorkersError, match="no Dask scheduler"):
        growing_pool.growing_pool(_fails).__enter__()


def _fails(fmu=None):
    raise ZeroDivisionError
