"""The memory of a law from a log: z' = a z + b with a(t), b(t) known at the samples.

Over an interval a is taken as the mean of its values at the two ends, and b as a straight line from b₀ to b₁,
so that a memory far shorter than the interval follows it; that step is exact,
    z(t_k + s) = z_k + (a z_k + b₀) s ψ₁(a s) + (b₁ - b₀)/h s² ψ₂(a s),
    ψ₁(x) = (e^x - 1)/x,   ψ_{n+1}(x) = (ψ_n(x) - 1/n!)/x,   d/ds s^n ψ_n(a s) = s^(n-1) ψ_{n-1}(a s).
"""

from math import factorial

import numpy as np

_DIGITS = 1e-17


def filtered(a: np.ndarray, b: np.ndarray, h: np.ndarray, start: float) -> np.ndarray:
    """z at the samples, (N,), over intervals of lengths h [s]: a (N - 1,), b (2, N - 1) at both ends."""
    from scipy.linalg import get_lapack_funcs

    if not len(h):
        return np.array([start])
    x, (first, last) = a * h, b
    gain, drive = np.exp(x), h * (first * _psi(1, x) + (last - first) * _psi(2, x))
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

    The integral of s^n ψ_n(a s) under the falling half of a hat is h^(n+1) ψ_{n+2}(a h), under both halves
    h^(n+1) ψ_{n+1}(a h).
    """
    x, slope, bend = a * h, (b[0] + a * z[:-1]) * h, (b[1] - b[0]) * h
    second, third, fourth = (_psi(n, x) for n in (2, 3, 4))
    falling = z[:-1] + 2 * (slope * third + bend * fourth)
    rising = z[:-1] + 2 * (slope * (second - third) + bend * (third - fourth))
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
