"""Errors in the columns as well, against the closed form of Golub and Van Loan (1980, theorem 4.1)."""

import numpy as np
import pytest

from pyident.estimation.least_squares import solve_weighted
from pyident.estimation.total_least_squares import total_least_squares
from pyident.regression.reduced import reduce

TRUTH = np.array([2.0, -0.5])


@pytest.fixture(scope="module")
def data():
    """Columns of unit variance and a right-hand side, all with errors of one relative size."""
    rng = np.random.default_rng(4)
    A = rng.standard_normal((5000, 2))
    y = A @ TRUTH
    return A + 0.3 * rng.standard_normal(A.shape), y + 0.3 * np.std(y) * rng.standard_normal(len(y))


def test_it_is_the_closed_form(data):
    """p = (AᵀA - s² 1)⁻¹ Aᵀy, s the least singular value of [A, y], every column of unit length."""
    A, y = data
    reduced = reduce([(A[:, None, :], y[:, None])], ("joint1.e",), ("a", "b"))
    least = solve_weighted(reduced)
    found = total_least_squares(reduced, least)
    length, of_y = np.linalg.norm(A, axis=0), np.linalg.norm(y)
    B, b = A / length, y / of_y
    s = np.linalg.svd(np.column_stack([B, b]), compute_uv=False)[-1]
    expected = np.linalg.solve(B.T @ B - s**2 * np.eye(2), B.T @ b) * of_y / length
    np.testing.assert_allclose(found.p, expected, rtol=1e-8)
    assert np.linalg.norm(found.p - TRUTH) < 0.3 * np.linalg.norm(least.p - TRUTH)
    assert np.isnan(found.covariance).all()  # it gives no interval


def test_without_errors_it_is_least_squares():
    A = np.random.default_rng(1).standard_normal((200, 2))
    reduced = reduce([(A[:, None, :], (A @ TRUTH)[:, None])], ("joint1.e",), ("a", "b"))
    np.testing.assert_allclose(total_least_squares(reduced, solve_weighted(reduced)).p, TRUTH, rtol=1e-9)
