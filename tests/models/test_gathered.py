"""Work in threads: in order, nested, and ended when one fails."""

import threading

import pytest

from flexmodels.threads import gathered
from pyident.regression.machine.threads import spread


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr("flexmodels.threads.cores", lambda: 2)
    monkeypatch.setattr("pyident.regression.machine.threads.cores", lambda: 2)


def test_results_come_in_the_order_of_the_items_whoever_is_first():
    late = threading.Event()

    def work(item):
        if item == 0:
            assert late.wait(10)
        if item == 1:
            late.set()
        return item**2

    assert gathered(work, range(20)) == [i**2 for i in range(20)]


def test_work_may_share_out_work_itself():
    def work(item):
        parts: list[slice] = []
        spread(parts.append, samples=1000, most=10)
        return item, sum(part.stop - part.start for part in parts)

    assert gathered(work, range(8)) == [(i, 1000) for i in range(8)]


def test_what_has_not_begun_when_one_fails_does_not_begin():
    begun: list[int] = []
    release = threading.Event()

    def work(item):
        begun.append(item)
        if item == 0:
            raise ValueError("no")
        release.wait(1)

    with pytest.raises(ValueError, match="no"):
        gathered(work, range(200))
    release.set()
    assert len(begun) < 200


def test_the_others_are_told_before_they_are_waited_for():
    told = threading.Event()

    def work(item):
        if item == 0:
            raise ValueError("no")
        assert told.wait(10)

    with pytest.raises(ValueError, match="no"):
        gathered(work, range(2), told.set)
