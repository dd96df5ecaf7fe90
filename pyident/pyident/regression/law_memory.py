"""The memory of a law from a log: z' = a z + b with a(t), b(t) known at the samples.

Over an interval a and b are taken as the mean of their values at its two ends; that step is exact,
    z(t_k + s) = z_k + (a z_k + b) s ψ₁(a s),   ψ₁(x) = (e^x - 1)/x,   ψ_{n+1}(x) = (ψ_n(x) - 1/n!)/x.
"""

from math import factorial

import numpy as np

_DIGITS = 1e-17


def filtered(a: np.ndarray, b: np.ndarray, h: np.ndarray, start: float) -> np.ndarray:
    """z at the samples, (N,), from a, b over the intervals, (N - 1,), of lengths h [s]."""
    from scipy.linalg import get_lapack_funcs

    if not len(h):
        return np.array([start])
    gain, drive = np.exp(a * h), b * h * _psi(1, a * h)
    if not (gain <= 1).all():  # elimination would pivot, and a state that grows overflow backwards
        return _stepped(gain, drive, start)
    ones, nothing = np.ones(len(gain) + 1), np.zeros(len(gain))
    (gtsv,) = get_lapack_funcs(("gtsv",), (drive,))
    return np.asarray(gtsv(-gain, ones, nothing, np.append(start, drive))[3])  # z' - gain z = drive


def _stepped(gain: np.ndarray, drive: np.ndarray, start: float) -> np.ndarray:
    z = [start]
    for g, d in zip(gain.tolist(), drive.tolist(), strict=True):
        z.append(g * z[-1] + d)
    return np.array(z)


def hat_means(z: np.ndarray, a: np.ndarray, b: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Means of z under the hat function of each sample, (N,); at both ends of the half that there is.

    The integral of s ψ₁(a s) under the falling half of a hat is h² ψ₃(a h), under both halves h² ψ₂(a h).
    """
    x, slope = a * h, (b + a * z[:-1]) * h
    second, third = _psi(2, x), _psi(3, x)
    falling = z[:-1] + 2 * slope * third
    rising = z[:-1] + 2 * slope * (second - third)
    return np.concatenate([falling[:1], (rising[:-1] + falling[1:]) / 2, rising[-1:]])


def _psi(n: int, x: np.ndarray) -> np.ndarray:
    """By its series where the recursion would cancel."""
    small = np.abs(x) < 1
    near = np.where(small, x, 0.0)
    series = np.polyval([1 / factorial(j + n) for j in reversed(range(_terms(n, near)))], near)
    if small.all():
        return series
    safe = np.where(small, 1.0, x)
    value = np.exp(safe)
    for i in range(n):
        value = (value - 1 / factorial(i)) / safe
    return np.where(small, series, value)


def _terms(n: int, x: np.ndarray) -> int:
    """Of the series of ψ_n, up to the last digit for |x| < 1."""
    largest = float(np.abs(x).max(initial=0.0))
    return next(j for j in range(1, 19) if largest**j * factorial(n) / factorial(j + n) < _DIGITS or j == 18)


def equilibrium(a: float, b: float) -> float:
    """Where the rate is zero; 0 where it is so everywhere."""
    return -b / a if a else 0.0
