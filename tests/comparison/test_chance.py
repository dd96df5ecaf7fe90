"""How often noise alone would be told as a place where a model fails: mean squares drawn from their law."""

import numpy as np
import pytest

from pyident.comparison.bins import Row, _judged
from pyident.rules.rules import RULES

PARTS, FREEDOM, DRAWS = 40, 8, 300
ROWS: list[Row] = [("frequency", "", float(i), float(i + 1), "Hz") for i in range(PARTS)]


def parts(squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Deviations and ratios of the first line, beside the others."""
    bins = _judged("joint1.e", ROWS, squares, np.full(PARTS, 100.0))
    return np.array([b.deviations for b in bins]), np.array([b.ratio for b in bins])


def false_alarms(certain: float) -> float:
    """Share of draws in which some part stands out, though data and replicas have one law."""
    rng = np.random.default_rng(5)
    rules, told = RULES.comparison, 0
    for _ in range(DRAWS):
        squares = rng.chisquare(FREEDOM, (1 + rules.replicas, PARTS)) / FREEDOM
        deviations, ratios = parts(squares)
        replicas = squares[1:]
        chance = max(
            parts(np.vstack([one, np.delete(replicas, i, axis=0)]))[0].max() for i, one in enumerate(replicas)
        )
        told += bool(np.any((deviations > certain * chance) & (ratios > rules.matters)))
    return told / DRAWS


def test_without_a_margin_the_data_are_the_largest_of_seven_equals():
    """Exchangeable: 1 in 7, if anything less, as a replica is judged by five others and not by six."""
    assert 1 / 20 < false_alarms(1.0) < 1 / 7 + 0.03


@pytest.mark.parametrize(("factor", "low", "high"), [(0.5, 0.4, 1.0), (1.0, 0.0, 0.05), (2.0, 0.0, 0.001)])
def test_nothing_stands_out_in_noise(factor, low, high):
    """As it is, in less than 5 % of draws; at half the margin in most."""
    assert low <= false_alarms(factor * RULES.comparison.certain) <= high
