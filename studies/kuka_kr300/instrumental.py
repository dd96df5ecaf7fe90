"""Coefficients of a signal that is measured with errors: two-stage least squares (Wright 1928; Theil 1953).

Least squares takes an error in a regressor for signal and finds too small a coefficient. Instruments are
columns that the true signal follows and its error does not: the signal's projection on them is free of the
error, and the regression on the projection is consistent. Janot, Vandanjon and Gautier (2014) identify robots
so.
"""

from dataclasses import dataclass

import numpy as np

from pyident.regression.machine.svd import svd

_SEEN = 1e-3  # of the largest singular value of the scaled instruments: below are no directions of their own
STRONG = 10.0  # F of the first stage below which instruments are weak (Staiger and Stock 1997)


@dataclass(frozen=True)
class Instrumented:
    """y = signal * p[0] + exact @ p[1:] + residual.

    std      standard deviations under residuals that are correlated in time (Newey and West 1987)
    F        how well the instruments beside the exact columns explain the signal
    """

    p: np.ndarray
    std: np.ndarray
    residual: np.ndarray
    F: float


def two_stage(
    signal: np.ndarray, exact: np.ndarray, instruments: np.ndarray, y: np.ndarray, lags: int
) -> Instrumented:
    """signal (N,) with errors, exact (N, K) without, instruments (N, Z), y (N,); lags: of the residuals."""
    U, s, _ = svd(_unit(np.column_stack([exact, instruments])))
    U = U[:, s > _SEEN * s[0]]
    projected = U @ (U.T @ signal)
    A = np.column_stack([projected, exact])
    scale = np.linalg.norm(A, axis=0)
    p = np.linalg.lstsq(A / scale, y, rcond=None)[0] / scale
    residual = y - np.column_stack([signal, exact]) @ p
    covariance = _coloured(A / scale, residual, lags)
    return Instrumented(p, np.sqrt(np.diag(covariance)) / scale, residual, _strength(U, signal, exact))


def _strength(U: np.ndarray, signal: np.ndarray, exact: np.ndarray) -> float:
    """F of the instruments in the first stage; U (N, r) spans them and the exact columns."""
    own, _ = np.linalg.qr(_unit(exact))
    rest = signal - own @ (own.T @ signal)
    explained = U @ (U.T @ signal) - own @ (own.T @ signal)
    left = rest @ rest - explained @ explained
    freedom = U.shape[1] - own.shape[1]
    return float((explained @ explained / freedom) / (left / (len(signal) - U.shape[1])))


def _coloured(A: np.ndarray, residual: np.ndarray, lags: int) -> np.ndarray:
    moments = A * residual[:, None]
    meat = moments.T @ moments
    for lag in range(1, lags + 1):
        product = moments[lag:].T @ moments[:-lag]
        meat += (1 - lag / (lags + 1)) * (product + product.T)
    bread = np.linalg.inv(A.T @ A)
    return bread @ meat @ bread


def _unit(A: np.ndarray) -> np.ndarray:
    return A / np.maximum(np.linalg.norm(A, axis=0), 1e-300)
