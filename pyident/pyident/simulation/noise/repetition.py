"""What does not repeat in a log whose motion does: noise, whatever the robot is.

Along a periodic motion every law of it leaves the same in every period (Swevers et al. 1997 average it so).
What differs between the periods, but for a slow course over them as of friction that warms up, is noise, at
low frequencies too, where no model could tell it from physics. The way there and back again may be recorded
as well.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

_LEFT = 0.2  # of a coordinate's variance, by which it must have moved away before it comes back
_RETURNS = 1e-4  # of its variance: the mean square by which a period may differ from the next
_DEGREE = 11  # of splines between samples: what lies near the Nyquist frequency keeps its size
_LEAST, _MANY = 3, 6  # periods: to tell noise at all, and to take away a curved course over them
_CUTS = (0.05, 0.1, 0.15, 0.2, 0.3)  # of a log, that are no part of the repetition at an end, or at both


@dataclass(frozen=True)
class Repetition:
    """A motion that comes back after `period` samples, in some rows of a log."""

    period: float
    rows: slice


def repetition_of(q: np.ndarray, noise: np.ndarray) -> Repetition | None:
    """Where all coordinates (N, n) repeat at least three times, with as little cut off as may be.

    noise   (n,) standard deviations of their sensors
    """
    ends = [(0.0, 0.0), *(e for c in _CUTS for e in ((c, 0.0), (0.0, c), (c, c)))]
    for before, after in ends:
        rows = slice(round(before * len(q)), len(q) - round(after * len(q)))
        period = period_of(q[rows], noise)
        if period is not None:
            return Repetition(period, rows)
    return None


def period_of(q: np.ndarray, noise: np.ndarray) -> float | None:
    """Samples after which all coordinates (N, n) come back, at least three times; None where they do not.

    noise   (n,) standard deviations of their sensors
    """
    spread = q.std(axis=0)
    moving = spread > 10 * noise
    if not moving.any():
        return None
    x = (q[:, moving] - q[:, moving].mean(axis=0)) / spread[moving]
    allowed = _RETURNS + 2 * float(np.square(noise[moving] / spread[moving]).mean())
    d = _difference(x)
    away = np.flatnonzero(d > _LEFT)
    if not len(away):
        return None
    for lag in range(max(int(away[0]), 1), len(x) // _LEAST + 1):
        before, here, after = d[lag - 1 : lag + 2]
        bend = before - 2 * here + after
        if here > min(before, after) or bend <= 0:
            continue
        shift = 0.5 * (before - after) / bend
        if here - 0.25 * (before - after) * shift <= allowed and (lag + shift) * _LEAST <= len(x):
            return float(lag + shift)
    return None


def unrepeated(x: np.ndarray, period: float) -> tuple[np.ndarray, float, float]:
    """What of a signal (N,) differs between its periods, with the power of its noise; its sampling period
    over that of the signal; and the share of it that is independent."""
    length = round(period)
    count = int(len(x) / period + 1e-3)  # the last one may end with the log
    at = np.minimum(np.arange(count * length) * (period / length), len(x) - 1)
    rows = make_interp_spline(np.arange(len(x)), x, _DEGREE)(at).reshape(count, length)
    degree = 2 if count >= _MANY else 1
    course = np.polynomial.legendre.legvander(np.linspace(-1, 1, count), degree)
    basis = np.linalg.qr(course)[0]
    kept = 1 - np.square(basis).sum(axis=1)  # of the noise's power in each period
    left = (rows - basis @ (basis.T @ rows)) / np.sqrt(kept)[:, None]
    return left.ravel(), period / length, float(kept.mean())


def _difference(x: np.ndarray) -> np.ndarray:
    """(N // 3 + 2,) mean square of x(t + lag) - x(t) per lag, x (N, n) of unit variance."""
    N = len(x)
    lags = np.arange(min(N // _LEAST + 2, N - 1))
    S = np.abs(np.fft.rfft(x, 2 * N, axis=0)) ** 2
    r = np.fft.irfft(S, 2 * N, axis=0)[: len(lags)].mean(axis=1)
    c = np.concatenate([[0.0], np.cumsum(np.square(x).mean(axis=1))])
    return (c[N - lags] + c[N] - c[lags] - 2 * r) / (N - lags)
