"""Gains against plain least squares of everything at once, which is what they stand for."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from pyident.diagnosis.base.projection import extended, gain, joined, solution_of, solve_base, taken_over

N, E, P = 2, 30, 4  # coordinates, equations, parameters


def _problem(seed, logs=2, K=2, imitated=False):
    """Per log equations (N, E) and columns on one coordinate, and all of it as one stacked system."""
    rng = np.random.default_rng(seed)
    whitened = [
        SimpleNamespace(A=rng.standard_normal((N, E, P)), y=rng.standard_normal((N, E))) for _ in range(logs)
    ]
    columns = [{1: rng.standard_normal((E, K))} for _ in range(logs)]
    if imitated:
        for log, rows in zip(whitened, columns, strict=True):
            log.A[0] = 0.0
            rows[1][:, 0] = log.A[1] @ [1.0, -2.0, 0.5, 3.0]
    dense = [np.stack([np.zeros((E, K)), rows[1]]) for rows in columns]
    A = np.vstack([log.A.reshape(-1, P) for log in whitened])
    X = np.vstack([d.reshape(-1, K) for d in dense])
    y = np.concatenate([log.y.ravel() for log in whitened])
    return cast(Any, whitened), columns, A, X, y


def _energy(A, y):
    p, *_ = np.linalg.lstsq(A, y, rcond=None)
    return float(np.square(y - A @ p).sum()), p


def _free(K):
    return np.full(K, -np.inf), np.full(K, np.inf)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 3), st.integers(1, 3))
def test_gain_is_what_a_new_fit_of_everything_gains(seed, logs, K):
    """Frisch and Waugh: energy, coefficients and standard deviations."""
    whitened, columns, A, X, y = _problem(seed, logs, K)
    base = solve_base(whitened)
    alone, p = _energy(A, y)
    both = np.column_stack([A, X])
    together, all_of_them = _energy(both, y)
    found = gain(base, columns, *_free(K))
    assert base.energy == pytest.approx(alone)
    assert base.p == pytest.approx(p)
    assert found.energy == pytest.approx(alone - together, rel=1e-8, abs=1e-10)
    assert found.coefficients == pytest.approx(all_of_them[P:], rel=1e-7, abs=1e-10)
    spread = np.sqrt(np.diag(np.linalg.inv(both.T @ both)))[P:]
    assert found.std == pytest.approx(spread, rel=1e-7)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 3), st.floats(0.0, 0.5))
def test_bounds_are_those_of_a_bounded_fit(seed, K, lowest):
    """SciPy's bounded least squares of everything, the model's own parameters free."""
    whitened, columns, A, X, y = _problem(seed, 2, K)
    base = solve_base(whitened)
    lower, upper = np.full(K, lowest - 0.25), np.full(K, 1.0)
    reference = lsq_linear(
        np.column_stack([A, X]),
        y,
        (np.r_[np.full(P, -np.inf), lower], np.r_[np.full(P, np.inf), upper]),
        tol=1e-12,
    )
    found = gain(base, columns, lower, upper)
    assert found.coefficients == pytest.approx(reference.x[P:], abs=1e-5)
    assert found.energy == pytest.approx(base.energy - 2 * reference.cost, abs=1e-4)


def test_what_the_base_imitates_gains_nothing():
    whitened, columns, A, _, _ = _problem(0, imitated=True)
    base = solve_base(whitened)
    found = gain(base, columns, *_free(2))
    assert np.isinf(found.std[0])
    assert np.isfinite(found.std[1])
    only = gain(base, [{1: rows[1][:, :1]} for rows in columns], *_free(1))
    assert only.energy == 0.0
    taken = taken_over(base, columns)[:, 0]
    assert A @ taken == pytest.approx(A @ [1.0, -2.0, 0.5, 3.0])


def test_a_law_in_the_base_leaves_others_what_a_joint_fit_leaves_them():
    whitened, first, A, X, y = _problem(1)
    _, second, _, Z, _ = _problem(2)
    base = extended(solve_base(whitened), first)
    assert base.energy == pytest.approx(_energy(np.column_stack([A, X]), y)[0])
    beside = gain(base, second, *_free(2)).energy
    every = _energy(np.column_stack([A, X, Z]), y)[0]
    assert beside == pytest.approx(base.energy - every)
    both = gain(solve_base(whitened), joined([first, second]), *_free(4)).energy
    assert both == pytest.approx(_energy(A, y)[0] - every)


def test_joined_columns_on_different_equations():
    out = joined([[{0: np.ones((3, 1))}], [{1: np.full((3, 2), 2.0)}]])
    assert set(out[0]) == {0, 1}
    np.testing.assert_array_equal(out[0][0], [[1, 0, 0]] * 3)
    np.testing.assert_array_equal(out[0][1], [[0, 2, 2]] * 3)


def test_what_is_left_of_forces_that_cancel_determines_nothing():
    """A moment about gravity: rounding, 1e-16 of other columns, was scaled to one and took 1e14 kg m."""
    rng = np.random.default_rng(5)
    A = rng.normal(size=(400, 4)) * [100.0, 10.0, 1.0, 1e-14]
    y = A[:, :3] @ [0.5, -2.0, 3.0] + 0.01 * rng.normal(size=400)
    triangle = np.asarray(np.linalg.qr(np.column_stack([A, y]), mode="r"))
    p, directions = solution_of([triangle])
    np.testing.assert_allclose(p, [0.5, -2.0, 3.0, 0.0], atol=0.01)
    assert directions.shape == (4, 3)
