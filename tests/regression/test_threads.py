"""Shared-out samples are each worked on once; what fails in a thread is heard of."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmodels.cores import cores
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
