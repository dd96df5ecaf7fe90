"""Waves over an angle: which periods per turn of a joint show in a signal, and the signal without them.

A signal is held against cos nφ and sin nφ of an angle for every order n that the motion resolves and the
sampling can follow; an order counts against the median of its neighbours, and against all that were tried.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar
from scipy.stats import gamma

from flexmodels.joint import Joint
from pyident.rules.confidence import PERIODS
from pyident.rules.periodic import PeriodicRules

_PER_PEAK = 3.0  # orders tried per resolved one
_MEDIAN = float(np.log(2))  # of an exponential variable, per its mean
_MOST = 0.5  # of a signal's energy
_ANSWERED = 2  # peaks with a size of their own at every speed: each costs as much as many laws
_BLOCK = 64  # orders at once


def highest_of(joint: Joint, rules: PeriodicRules) -> float:
    """The highest order that is tried: of a turn, or of 2 pi metres where there are as many in a metre."""
    return rules.highest * (2 * np.pi if joint.kind == "prismatic" else 1.0)


def orders_within(
    angles: Sequence[np.ndarray], speeds: np.ndarray, period: float, highest: float, rules: PeriodicRules
) -> np.ndarray:
    """(F,) orders per turn that the motion resolves and the sampling follows; may be none."""
    span = span_of(angles)
    moving = speeds[speeds > 0.1 * speeds.max()] if speeds.max() > 0 else speeds[:0]
    if span <= 0 or not len(moving):
        return np.zeros(0)
    top = min(highest, rules.fastest * np.pi / period / float(np.median(moving)))
    return np.arange(max(rules.lowest, 4 * np.pi / span), top, 2 * np.pi / span / _PER_PEAK)


def span_of(angles: Sequence[np.ndarray]) -> float:
    """Of the angles of several logs, the widest range of one [rad]."""
    return max(float(np.ptp(q)) for q in angles)


def lowest_order(angles: Sequence[np.ndarray]) -> float:
    """Per turn, that of which the angles (N,) of a log pass just enough periods to be called periodic."""
    return PERIODS * 2 * np.pi / max(span_of(angles), 1e-9)


def peaks_of(
    left: Sequence[np.ndarray], angles: Sequence[np.ndarray], orders: np.ndarray, rules: PeriodicRules
) -> list[float]:
    """Orders that stand out of signals (N,) along angles (N,), the strongest first.

    At angles that are passed unevenly a strong wave fills its neighbours: one that is most of the signals
    counts against what these hold without it.
    """
    if len(orders) < rules.neighbours:
        return []
    chance = np.log(len(orders) / rules.chance) * (1 + len(left)) / 2  # of a mean over logs, at most
    step, found, rest = float(orders[1] - orders[0]), [], list(left)
    energy = _of_all(rest, angles, orders)
    while len(found) < rules.peaks:
        ratio = _over_neighbours(energy, rules)
        at = int(np.argmax(np.where(_apart(orders, found), ratio, 0.0)))
        order, own, before = float(orders[at]), energy[at], rest
        rest = [r - _wave(r, q, np.ones(len(q)), order, step) for r, q in zip(rest, angles, strict=True)]
        energy = _of_all(rest, angles, orders)
        most = _size(rest) < (1 - _MOST) * _size(before) and own >= chance * _noise(energy, rules)[at]
        if ratio[at] < chance and not most:
            break
        found.append(order)
    return found


def _size(signals: Sequence[np.ndarray]) -> float:
    return sum(float(np.square(x).sum()) for x in signals)


def peaks_at_speeds(
    left: Sequence[np.ndarray],
    angles: Sequence[np.ndarray],
    speeds: Sequence[np.ndarray],
    orders: np.ndarray,
    rules: PeriodicRules,
) -> list[float]:
    """The same of waves whose size and phase are those of the speed, as of what answers a wave: each part of
    the speeds has its own spectrum, and the sum of those, each over its noise, is a gamma variable.

    left, angles, speeds   per log (N,), the angle in rad;  orders (F,)
    """
    if len(orders) < rules.neighbours:
        return []
    edges = np.quantile(np.concatenate(speeds), np.linspace(0.0, 1.0, rules.speeds + 1)[1:-1])
    ratios = []
    for r, q, v in zip(left, angles, speeds, strict=True):
        part = np.digitize(v, edges)
        for i in np.unique(part):
            ratios.append(_over_neighbours(_energies(r[part == i], q[part == i], orders), rules))
    chance = float(gamma.isf(rules.chance / len(orders), len(ratios)))
    return _peaks(np.sum(ratios, axis=0), rules.answered * chance, orders, rules)[:_ANSWERED]


def _over_neighbours(energy: np.ndarray, rules: PeriodicRules) -> np.ndarray:
    """(F,) over the mean of what its neighbours say that noise is."""
    return energy / _noise(energy, rules)


def _noise(energy: np.ndarray, rules: PeriodicRules) -> np.ndarray:
    """(F,) the mean of noise, as the neighbours of an order have it."""
    return np.maximum(median_filter(energy, rules.neighbours, mode="reflect") / _MEDIAN, 1e-300)


def _apart(orders: np.ndarray, found: Sequence[float]) -> np.ndarray:
    """(F,) which orders are none of those found."""
    width = 2 * _PER_PEAK * (orders[1] - orders[0])
    return np.all([np.abs(orders - other) > width for other in found] or [np.ones(len(orders), bool)], axis=0)


def _peaks(ratio: np.ndarray, chance: float, orders: np.ndarray, rules: PeriodicRules) -> list[float]:
    out: list[float] = []
    for i in np.argsort(-ratio):
        if ratio[i] < chance or len(out) == rules.peaks:
            break
        if _apart(orders, out)[i]:
            out.append(float(orders[i]))
    return out


def without_waves(
    x: np.ndarray,
    angle: np.ndarray,
    speed: np.ndarray,
    known: np.ndarray,
    orders: np.ndarray,
    rules: PeriodicRules,
) -> np.ndarray:
    """The signal x (N,) without the waves over an angle (N,) that stand out of it where it is known (N,).

    speed (N,): waves of friction turn round with it;  orders: equidistant ones that are tried
    """
    out, at = x.copy(), angle[known]
    for turning in (np.ones(len(at)), np.sign(speed[known])):
        for order in peaks_of([(x[known] - x[known].mean()) * turning], [at], orders, rules):
            out[known] -= _wave(out[known], at, turning, order, float(orders[1] - orders[0]))
    return out


def _wave(x: np.ndarray, angle: np.ndarray, turning: np.ndarray, order: float, step: float) -> np.ndarray:
    """(N,): the wave near an order that takes most of x (N,)."""

    def of(n: float) -> np.ndarray:
        columns = np.column_stack([turning * np.cos(n * angle), turning * np.sin(n * angle)])
        return columns @ np.linalg.lstsq(columns, x, rcond=None)[0]

    bounds = (order - step, order + step)
    best: Any = minimize_scalar(lambda n: -float(np.square(of(n)).sum()), bounds=bounds, method="bounded")
    return of(float(best.x))


def _of_all(left: Sequence[np.ndarray], angles: Sequence[np.ndarray], orders: np.ndarray) -> np.ndarray:
    """(F,) energies of all logs."""
    return np.sum([_energies(r, q, orders) for r, q in zip(left, angles, strict=True)], axis=0)


def _energies(r: np.ndarray, q: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """|Σ r exp(i order q)|² at equidistant orders: a wave is one of the first few times that of its block."""
    first = np.exp(1j * np.outer(orders[:_BLOCK] - orders[0], q))
    blocks = r[:, None] * np.exp(1j * np.outer(q, orders[::_BLOCK]))
    return np.square(np.abs(first @ blocks)).T.ravel()[: len(orders)]
