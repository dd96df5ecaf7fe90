"""Work in another process: its result, its failure in one sentence, its end when cancelled."""

import os
import time

from pyident.workbench.jobs import Job


def squared(number, progress):
    progress(0.5)
    return number**2


def failing(progress):
    raise ValueError("column joint1.e is missing; add it")


def ending(progress):
    os._exit(3)


def endless(path, progress):
    while True:
        path.write_text(str(time.time()))
        time.sleep(0.01)


def test_a_result_comes_back():
    job = Job("squaring", squared, 7)
    job.wait(60)
    assert (job.state, job.result, job.progress) == ("done", 49, 1.0)


def test_a_failure_is_its_sentence():
    job = Job("failing", failing)
    job.wait(60)
    assert (job.state, job.error) == ("failed", "column joint1.e is missing; add it")


def test_a_process_that_dies_is_said():
    job = Job("ending", ending)
    job.wait(60)
    assert job.state == "failed"
    assert "ended" in job.error


def test_cancelled_work_ends(tmp_path):
    path = tmp_path / "alive"
    job = Job("endless", endless, path)
    while not path.exists() and job.running:
        time.sleep(0.01)
    job.cancel()
    job.wait(60)
    assert job.state == "cancelled"
    last = path.read_text()
    time.sleep(0.2)
    assert path.read_text() == last
