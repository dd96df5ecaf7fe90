"""Work shared out among cores: order, errors, and work that shares out work itself."""

import threading

import pytest

from pyident.regression.machine import threads


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr(threads, "cores", lambda: 2)
    threads._threads.cache_clear()
    threads._callers.cache_clear()
    yield
    threads._threads.cache_clear()
    threads._callers.cache_clear()


def test_results_come_in_the_order_of_the_items_whoever_is_first():
    late = threading.Event()

    def work(item):
        if item == 0:
            assert late.wait(10)
        if item == 1:
            late.set()
        return item**2

    assert threads.gathered(work, range(20)) == [i**2 for i in range(20)]


def test_work_may_share_out_work_itself():
    def work(item):
        parts: list[slice] = []
        threads.spread(parts.append, samples=1000, most=10)
        return item, sum(part.stop - part.start for part in parts)

    assert threads.gathered(work, range(8)) == [(i, 1000) for i in range(8)]


def test_what_has_not_begun_when_one_fails_does_not_begin():
    begun: list[int] = []
    release = threading.Event()

    def work(item):
        begun.append(item)
        if item == 0:
            raise ValueError("no")
        release.wait(1)

    with pytest.raises(ValueError, match="no"):
        threads.gathered(work, range(200))
    release.set()
    assert len(begun) < 200
