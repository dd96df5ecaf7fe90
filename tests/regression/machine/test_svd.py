"""Singular values where LAPACK's faster algorithm gives up."""

import numpy as np
import pytest

from pyident.regression.machine.svd import svd


@pytest.mark.parametrize("full", [False, True])
def test_the_slower_algorithm_takes_over(monkeypatch, full):
    def gives_up(*_, **__):
        raise np.linalg.LinAlgError("SVD did not converge")

    rng = np.random.default_rng(0)
    A = rng.standard_normal((7, 3)) @ rng.standard_normal((3, 5))  # of rank 3
    monkeypatch.setattr(np.linalg, "svd", gives_up)
    U, s, Vt = svd(A, full=full)
    assert U.shape == ((7, 7) if full else (7, 5))
    assert U[:, :5] * s @ Vt == pytest.approx(A, abs=1e-13)
    assert np.square(s[:3]) == pytest.approx(np.linalg.eigvalsh(A.T @ A)[:1:-1], rel=1e-10)
    assert s[3:] == pytest.approx(0, abs=1e-14)
