"""Distances of links: against a search over both lines, and in poses where the answer is plain."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import minimize

from flexmodels.files.robot_file import load_robot
from pyident.excitation.capsules import between, clearances, geometry_of


def brute_force(a, b, c, d) -> float:
    """The least distance by bounded minimisation from a grid of starts."""

    def square(x):
        return float(np.sum((a + x[0] * (b - a) - c - x[1] * (d - c)) ** 2))

    starts = [(s, t) for s in (0.1, 0.5, 0.9) for t in (0.1, 0.5, 0.9)]
    found = [minimize(square, x0, bounds=[(0, 1), (0, 1)], tol=1e-14).fun for x0 in starts]
    return float(np.sqrt(min(found)))


def test_segments_are_as_far_apart_as_a_search_says():
    a, b, c, d = np.random.default_rng(0).uniform(-1, 1, (4, 40, 3))
    d[:10] = c[:10] + 0.7 * (b - a)[:10]  # parallel ones
    d[10:13] = c[10:13]  # points
    expected = [brute_force(*ends) for ends in zip(a, b, c, d, strict=True)]
    assert between(a, b, c, d) == pytest.approx(expected, abs=1e-5)


def pose(*angles: float) -> pd.DataFrame:
    return pd.DataFrame([angles], columns=[f"joint{k}.e" for k in range(1, len(angles) + 1)])


def nearest(frame: pd.DataFrame) -> dict[str, float]:
    found = clearances(geometry_of(load_robot("four_link"), radius=0.06), frame)
    return {c.what: float(c.distance.min()) for c in found}


def test_an_arm_that_folds_back_meets_itself():
    assert min(nearest(pose(0, 0, 0, 0)).values()) > 0
    assert min(nearest(pose(0, 0, 1.5, 0)).values()) > 0
    folded = nearest(pose(0, 0, np.pi, 0))
    assert folded["link 2 and link 4"] < 0


def test_an_arm_that_bends_down_meets_the_floor():
    down = nearest(pose(0, 2.6, 0, 0))  # the tip at 0.42 + 0.985 cos 2.6 = -0.42 m
    assert down["link 4 and the floor"] == pytest.approx(0.42 + 0.985 * np.cos(2.6) - 0.06, abs=1e-9)
    assert down["link 4 and the floor"] < 0


def test_without_gravity_there_is_no_floor():
    from dataclasses import replace

    shape = geometry_of(replace(load_robot("four_link"), gravity=(0.0, 0.0, 0.0)))
    assert shape.floor is None
    assert any("no gravity" in note for note in shape.notes)
