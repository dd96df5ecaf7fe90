"""Columns that are zero but for rounding, against values that are known."""

import numpy as np
import pytest

from pyident.estimation.least_squares import solve
from pyident.regression.reduced import reduce

RNG = np.random.default_rng(5)
TRUE = np.array([3.0, 40.0, 5e6])
NAMES = ("link1.ms[x]", "link2.ms[y]", "joint1.k[1]")


def solved(second: np.ndarray):
    twist = 1e-13 * RNG.standard_normal(400)  # real, though far smaller than the columns of links
    A = np.column_stack([RNG.standard_normal(400), second, twist])
    y = A @ TRUE
    return solve(reduce([(A[:, None, :], y[:, None])], ("joint1.e",), NAMES))


def test_a_link_column_of_rounding_is_no_direction_that_is_seen():
    found = solved(1e-16 * RNG.standard_normal(400))
    assert found.rank == 2
    assert found.p == pytest.approx([3.0, 0.0, 5e6], rel=1e-9, abs=1e-9)
    assert not found.seen[1].any()


def test_a_small_column_that_is_real_is_seen():
    found = solved(1e-9 * RNG.standard_normal(400))
    assert found.rank == 3
    assert found.p == pytest.approx(TRUE, rel=1e-4)
