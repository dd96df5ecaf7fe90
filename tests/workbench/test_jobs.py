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


def number(progress):
    return os.getpid()


def test_work_goes_to_the_process_that_waits():
    first, second = Job("who", number), Job("who else", number)
    first.wait(60)
    second.wait(60)
    assert first.result != second.result  # both at once
    third = Job("who now", number)
    third.wait(60)
    assert third.result in (first.result, second.result)


def test_work_that_is_cancelled_takes_its_process_along(tmp_path):
    before = Job("who", number)
    before.wait(60)
    path = tmp_path / "alive"
    job = Job("endless", endless, path)
    while not path.exists() and job.running:
        time.sleep(0.01)
    job.cancel()
    after = Job("who now", number)
    after.wait(60)
    assert (after.state, after.result != before.result) == ("done", True)
