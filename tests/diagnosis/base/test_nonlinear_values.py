"""Between the values of a grid: the best one is found, and never beyond the neighbours."""

import pytest
from two_link_logs import two_link

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.nonlinear_values import refined

GRID = [Candidate("stribeck", 1, (("velocity", v),)) for v in (0.05, 0.1, 0.2, 0.4)]


def _explained(best):
    return lambda candidate: 1e5 * (1.0 - (dict(candidate.values)["velocity"] - best) ** 2)


def test_the_best_value_between_neighbours():
    found = refined(two_link(), GRID[1], GRID, _explained(0.13))
    assert dict(found.values)["velocity"] == pytest.approx(0.13, abs=0.003)


def test_a_best_value_beyond_the_neighbours_is_not_followed():
    found = refined(two_link(), GRID[1], GRID, _explained(0.9))
    assert dict(found.values)["velocity"] == pytest.approx(0.2, abs=0.005)


def test_a_law_without_such_values_is_left_alone():
    start = Candidate("asymmetric_coulomb", 1)
    assert refined(two_link(), start, [start], lambda _: 1.0) is start


def test_a_value_that_noise_hardly_tells_from_the_start_is_the_start():
    assert refined(two_link(), GRID[1], GRID, lambda c: 1e-4 * _explained(0.2)(c)) is GRID[1]
