"""Designs and sensitivities against closed forms."""

import numpy as np
import pandas as pd
import pytest

from pyident.sweep.sampling import grid, latin_hypercube, sobol
from pyident.sweep.sensitivity import morris_design, sensitivity, sobol_indices_design
from pyident.sweep.store import StudyError

pytest.importorskip("SALib")
RANGES = {"a": (0.0, 1.0), "b": (-2.0, 2.0), "c": (10.0, 20.0)}


def test_grid():
    assert grid({"a": [1, 2], "b": [3, 4, 5]}).to_numpy().tolist() == [
        [1, 3], [1, 4], [1, 5], [2, 3], [2, 4], [2, 5],
    ]  # fmt: skip


def test_latin_hypercube_has_one_value_in_each_interval():
    design = latin_hypercube(RANGES, 50, seed=3)
    for name, (low, high) in RANGES.items():
        interval = np.floor((design[name] - low) / (high - low) * 50).astype(int)
        assert sorted(interval) == list(range(50))
    assert design.equals(latin_hypercube(RANGES, 50, seed=3))


def test_sobol_fills_every_elementary_interval():
    design = sobol({"a": (0.0, 1.0), "b": (0.0, 2.0)}, 60)
    assert len(design) == 64
    cells = np.floor(design.to_numpy() / [1 / 8, 2 / 8])  # a (0, 6, 2)-net: one point in each of 8 x 8 cells
    assert len(np.unique(cells, axis=0)) == 64


def test_morris_of_a_linear_function():
    """Every elementary effect is the slope times the range."""
    design = morris_design(RANGES, 30)
    assert len(design) == 32
    result = 3 * design["a"] - 5 * design["b"] + 0.5 * design["c"]
    found = sensitivity("morris", RANGES, design, result.to_numpy())
    np.testing.assert_allclose(found["mu"], [3.0, -20.0, 5.0], rtol=1e-9)
    np.testing.assert_allclose(found["sigma"], 0.0, atol=1e-9)


def test_sobol_indices_of_the_ishigami_function():
    """Closed form: Ishigami and Homma, 1990, with a = 7 and b = 0.1."""
    ranges = dict.fromkeys("xyz", (-np.pi, np.pi))
    design = sobol_indices_design(ranges, 20_000)
    x, y, z = design.to_numpy().T
    found = sensitivity(
        "sobol_indices", ranges, design, np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
    )
    of_x, of_y = 0.5 * (1 + 0.1 * np.pi**4 / 5) ** 2, 49 / 8
    of_xz = 0.1**2 * np.pi**8 * (1 / 18 - 1 / 50)
    total = of_x + of_y + of_xz
    np.testing.assert_allclose(found["S1"], np.array([of_x, of_y, 0]) / total, atol=0.01)
    np.testing.assert_allclose(found["ST"], np.array([of_x + of_xz, of_y, of_xz]) / total, atol=0.01)


def test_failed_runs_take_their_trajectory_with_them():
    design = morris_design(RANGES, 30)
    result = (3 * design["a"]).to_numpy(copy=True)
    result[5] = np.nan
    found = sensitivity("morris", RANGES, design, result)
    np.testing.assert_allclose(found["mu"], [3.0, 0.0, 0.0], atol=1e-9)
    with pytest.raises(StudyError, match="only 0 succeeded"):
        sensitivity("morris", RANGES, design, np.full(len(design), np.nan))


def test_one_result_per_run_of_the_design():
    assert isinstance(sobol_indices_design(RANGES, 100), pd.DataFrame)
    assert len(sobol_indices_design(RANGES, 100)) == 160  # the next power of two, 32 blocks of 5
