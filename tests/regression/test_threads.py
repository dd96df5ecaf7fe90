"""Shared-out samples are each worked on once; what fails in a thread is heard of."""

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmodels.cores import cores
from pyident.regression.machine import threads
from pyident.regression.machine.threads import each, spread


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 300), st.integers(1, 50))
def test_every_sample_once(samples, most):
    touched = np.zeros(samples, int)

    def work(part: slice) -> None:
        assert part.stop - part.start <= most
        touched[part] += 1

    spread(work, samples, most)
    assert (touched == 1).all()


@pytest.mark.parametrize("available", [1, 2])
def test_errors_come_back(monkeypatch, available):
    monkeypatch.setattr("pyident.regression.machine.threads.cores", lambda: available)

    def work(item: int) -> None:
        if item == 3:
            raise ValueError("third")

    with pytest.raises(ValueError, match="third"):
        each(work, range(5))


def test_cores_are_those_of_this_process():
    assert cores() >= 1


@pytest.fixture
def two_cores(monkeypatch):
    monkeypatch.setattr(threads, "cores", lambda: 2)
    threads._threads.cache_clear()
    threads._callers.cache_clear()
    yield
    threads._threads.cache_clear()
    threads._callers.cache_clear()


def test_results_come_in_the_order_of_the_items_whoever_is_first(two_cores):
    late = threading.Event()

    def work(item):
        if item == 0:
            assert late.wait(10)
        if item == 1:
            late.set()
        return item**2

    assert threads.gathered(work, range(20)) == [i**2 for i in range(20)]


def test_work_may_share_out_work_itself(two_cores):
    def work(item):
        parts: list[slice] = []
        threads.spread(parts.append, samples=1000, most=10)
        return item, sum(part.stop - part.start for part in parts)

    assert threads.gathered(work, range(8)) == [(i, 1000) for i in range(8)]


def test_what_has_not_begun_when_one_fails_does_not_begin(two_cores):
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
