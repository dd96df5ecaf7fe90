"""Instrumental variables for the equations of a robot: Z'W(y − Φ p) = 0 in place of Φ'W(y − Φ p) = 0.

Sensor noise in Φ biases least squares: it takes noise for motion. Instruments Z follow the motion but not the
noise, so that what noise there is in y − Φ p is uncorrelated with them (Janot, Vandanjon and Gautier 2014).
The mask that leaves reversals out fades in and out: noise of second differences cancels in the sums of smooth
instruments, and would not at a hard edge.

The covariance is a sandwich in the frequency domain. A sum over samples of instrument times residual is a sum
over frequencies, and its variance needs the residual's spectrum where the instruments have theirs: the
periodogram, smoothed over neighbouring bins, with all its correlations between equations. Lags in time would
let the noise of high frequencies, which differences raise as f squared, leak into it.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from pyident.estimation.least_squares import ROUNDING, Directions, Solution, solution_of
from pyident.regression.reduced import Reduced, reduce

FADE = 6  # samples over which the mask fades
_BINS = 8  # neighbours on either side over which the periodogram is smoothed


@dataclass(frozen=True)
class Rows:
    """One log's equations with instruments: A, Z (N, n, P), y (N, n), and how much each counts (N, n)."""

    A: np.ndarray
    Z: np.ndarray
    y: np.ndarray
    share: np.ndarray


Logs = Callable[[], Iterable[Rows]]
Scatter = Callable[[np.ndarray, np.ndarray], np.ndarray]  # directions (P, r), p (P,) -> (r, r)


def fading(use: np.ndarray, fade: int = FADE) -> np.ndarray:
    """(N, n) a mask of 0 and 1 that falls smoothly to 0 before it is 0, and at both ends."""
    window = np.hanning(2 * fade + 1)
    window /= window.sum()
    n = len(use)
    padded = np.pad(use.astype(float), ((2 * fade, 2 * fade), (0, 0)))
    free = np.lib.stride_tricks.sliding_window_view(padded, 2 * fade + 1, axis=0).min(axis=-1)
    free = np.lib.stride_tricks.sliding_window_view(free, 2 * fade + 1, axis=0)
    return (free @ window)[:n]


def solve_instrumental(
    logs: Logs,
    reduced: Reduced,
    weights: np.ndarray,
    scatter: Scatter,
    rank: int | None = None,
) -> Solution:
    """The solution, its covariance and the directions that the instruments span.

    reduced   of the same logs, for the names and the residuals
    weights   (n,) of the coordinates' equations
    scatter   covariance of the sums of instrument times residual, `spectral` or another
    rank      none: directions whose standard deviation is above the largest coefficient are left out
    """
    blocks = ((r.Z * r.share[:, :, None], 0 * r.y) for r in logs())
    instruments = reduce(blocks, reduced.rows, reduced.columns)
    S, _ = instruments.stacked(weights)
    scale = np.linalg.norm(S, axis=0)
    absent = scale == 0
    scale[absent] = 1.0
    _, s, Vt = np.linalg.svd(S / scale, full_matrices=False)
    r = int((s > ROUNDING * s[0]).sum())
    Vt[:r, absent] = 0.0
    turn = (Vt[:r].T / s[:r]) / scale[:, None]  # (P, r): Z turn has orthonormal columns
    B, b = _moments(logs, weights, turn)
    B = B @ (Vt[:r].T / scale[:, None])  # in scaled coordinates: near diag(s)
    a, spread = _leading(B, b, r)
    p = Vt[:r].T @ a / scale
    if rank is None:
        meat = scatter(turn, p)
        while r > 1 and _deviation(spread, meat, r) > np.abs(a[: r - 1]).max():
            r -= 1
            a, spread = _leading(B, b, r)
    else:
        r = min(rank, r)
        a, spread = _leading(B, b, r)
        meat = scatter(turn, Vt[:r].T @ a / scale)
    seen = Vt[:r].T
    root = (seen / scale[:, None]) @ spread
    covariance = root @ meat[:r, :r] @ root.T
    return solution_of(reduced, weights, seen @ a / scale, covariance, Directions(s, Vt, scale, r))


def _leading(B: np.ndarray, b: np.ndarray, r: int) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of the r leading directions, and what turns moments into them."""
    spread = np.linalg.inv(B[:r, :r])
    return spread @ b[:r], spread


def _deviation(spread: np.ndarray, meat: np.ndarray, r: int) -> float:
    """Standard deviation of the last of r coefficients."""
    return float(np.sqrt(max(spread[-1] @ meat[:r, :r] @ spread[-1], 0.0)))


def _moments(logs: Logs, weights: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sums of instruments, in orthonormal directions, times A and times y."""
    B, b = np.zeros((turn.shape[1], turn.shape[0])), np.zeros(turn.shape[1])
    for rows in logs():
        for c, weight in enumerate(weights):
            columns = np.flatnonzero(rows.A[:, c].any(axis=0))
            U = (weight**2 * rows.share[:, c, None]) * (rows.Z[:, c][:, columns] @ turn[columns])
            B[:, columns] += U.T @ rows.A[:, c][:, columns]
            b += U.T @ rows.y[:, c]
    return B, b


def spectral(logs: Logs, weights: np.ndarray, counted: Sequence[np.ndarray] | None = None) -> Scatter:
    """The covariance of the sums of instrument times residual, from the residual's spectrum.

    counted   per log (N // 2 + 1, n): share of the residual's amplitude that counts; none: all of it
    """
    return lambda turn, p: _spectral(logs, weights, turn, p, counted)


def unknown(turn: np.ndarray, _: np.ndarray) -> np.ndarray:
    """In place of a covariance that nobody will look at."""
    return np.full((turn.shape[1],) * 2, np.nan)


def _spectral(
    logs: Logs,
    weights: np.ndarray,
    turn: np.ndarray,
    p: np.ndarray,
    counted: Sequence[np.ndarray] | None,
) -> np.ndarray:
    total = np.zeros((turn.shape[1], turn.shape[1]))
    window = 1 - np.abs(np.arange(-_BINS, _BINS + 1)) / (_BINS + 1)
    window /= window.sum()
    for number, rows in enumerate(logs()):
        residual = (rows.y - rows.A @ p) * rows.share * weights
        N = len(residual)
        v = np.fft.fft(residual, axis=0)
        half = N // 2 + 1
        if counted is not None:
            v *= np.concatenate([counted[number], counted[number][1 : N - half + 1][::-1]])
        X = np.array([_spectrum(rows.Z[:, c], turn, weight) for c, weight in enumerate(weights)])
        twice = np.full(half, 2.0)
        twice[0] = 1.0
        if N % 2 == 0:
            twice[-1] = 1.0
        for shift, share in zip(range(-_BINS, _BINS + 1), window, strict=True):
            near = np.roll(v, -shift, axis=0)[:half]
            score = np.einsum("cfr,fc->fr", X, near, optimize=True) * np.sqrt(twice * share)[:, None] / N
            total += score.real.T @ score.real + score.imag.T @ score.imag
    return total


def _spectrum(Z: np.ndarray, turn: np.ndarray, weight: float) -> np.ndarray:
    """(F, r) conjugate transform of one equation's instruments."""
    columns = np.flatnonzero(Z.any(axis=0))
    return np.fft.rfft(weight * (Z[:, columns] @ turn[columns]), axis=0).conj()
