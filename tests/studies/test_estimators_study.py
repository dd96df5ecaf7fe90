"""The scores of the estimators' study against numbers that are drawn with known bias and spread."""

from dataclasses import dataclass

import numpy as np
import pytest
from studies.estimators.study import score


@dataclass
class Solution:
    p: np.ndarray
    std: np.ndarray


@dataclass
class Reduced:
    columns: tuple[str, ...]


@dataclass
class Result:
    solution: Solution
    reduced: Reduced


def test_bias_spread_and_coverage_are_those_that_were_drawn():
    rng = np.random.default_rng(6)
    true = {"a": 10.0, "b": -4.0, "zero": 0.0, "unseen": 1.0}
    columns = ("unseen", "zero", "b", "a")
    bias, std = np.array([0.0, 0.0, 0.4, 0.0]), np.array([9.0, 0.2, 0.04, 0.2])
    results = [
        Result(
            Solution(np.array([true[n] for n in columns]) + bias + std * rng.standard_normal(4), std),
            Reduced(columns),
        )
        for _ in range(4000)
    ]
    told = score(true, results, ["a", "b", "zero"], 3.0)  # pyright: ignore[reportArgumentType]
    assert told.worst == pytest.approx(10.0, rel=0.01)  # b is 0.4 of 4 too large
    assert told.bias == pytest.approx(5.0, rel=0.05)  # the median of 10 % and nearly 0
    assert told.spread == pytest.approx(1.5, rel=0.05)  # of 2 % and 1 %
    assert told.coverage == pytest.approx(100 * 2 * 0.95 / 3, abs=1.0)  # b is ten deviations off
    assert told.seconds == 3.0


def test_an_estimator_without_intervals_has_no_coverage():
    result = Result(Solution(np.array([1.1]), np.array([np.nan])), Reduced(("a",)))
    told = score({"a": 1.0}, [result], ["a"], 1.0)  # pyright: ignore[reportArgumentType]
    assert np.isnan(told.coverage)
    assert told.worst == pytest.approx(10.0)
