"""Whether what is left of an equation comes in bursts, where in all it is no more than its noise.

A floor is measured where the model leaves something. Pushes of a person below some hertz are in it as slow
noise, and nothing exceeds it. But noise fills all the time alike: over its floor, the slow part of what is
left has a chi-square's energy in every second, and a burst has many times that.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from pyident.diagnosis.result import Place
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.unexplained.in_time import course
from pyident.regression.spectrum import Equations

SLOW = 5.0  # Hz: faster is no push
_WINDOW = 1.0  # s
_IN_USE = 0.7  # of a window
_MATTERS = 5.0  # per cent of a torque, that its floor is
_CHANCE = 1e-5  # of any window
_SHARE = 0.5  # of what is left, in bursts
_RARE = 0.25  # of the time that they take at most


@dataclass(frozen=True)
class Bursts:
    """Share of an equation's slow remainder that lies in bursts, and where the strongest begins [s].

    log   its number;  count: of the bursts
    """

    share: float
    count: int
    log: int
    start: float


def in_bursts(beside: Search, places: Sequence[Place]) -> dict[int, Bursts]:
    """By row those motor sides whose noise comes in bursts, and matters.

    beside   rests on what was named;  places: of every row
    """
    found = {}
    for row, place in enumerate(places):
        calm = place.balance == "motor" and place.state in ("in_order", "explained")
        if calm and place.floor_percent >= _MATTERS:
            own = bursts(beside.examination.logs, [left[row] for left in beside.base.residual], row)
            found |= {} if own is None else {row: own}
    return found


def bursts(logs: Sequence[Equations], residual: Sequence[np.ndarray], row: int) -> Bursts | None:
    """Those in what is left of an equation, per log (2 bins,) over its level; None: in hardly any.

    A second of which little is in use, as at rest, tells nothing.
    """
    windows = [_energies(e, r, row) for e, r in zip(logs, residual, strict=True)]
    energies = np.concatenate([energy for energy, _ in windows])
    if len(energies) < 2 / _RARE:
        return None
    freedom = 2 * SLOW * _WINDOW
    typical = np.median(energies) / (chi2.median(freedom) / freedom)  # what bursts do not raise
    high = energies > typical * chi2.isf(_CHANCE / len(energies), freedom) / freedom
    share = float(energies[high].sum() / energies.sum()) if energies.any() else 0.0
    if share < _SHARE or high.mean() > _RARE:
        return None
    at = int(np.argmax(energies))
    log = int(np.searchsorted(np.cumsum([len(energy) for energy, _ in windows]), at, side="right"))
    start = np.concatenate([begin for _, begin in windows])[at]
    count = int(high[0]) + int((high[1:] & ~high[:-1]).sum())
    return Bursts(share, count, log, float(start))


def _energies(equations: Equations, residual: np.ndarray, row: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean squares of the slow part in windows of a row that are in use, and where each begins [s]."""
    band, samples = equations.band, len(equations.part.target)
    slow = residual * np.tile(band.frequencies <= SLOW, 2)
    x, n = np.square(course(band, slow, samples)), max(round(_WINDOW / band.period), 1)
    whole = len(x) // n
    energy, use = (v[: whole * n].reshape(whole, n).mean(axis=1) for v in (x, equations.part.use[:, row]))
    told = use > _IN_USE
    return energy[told] / use[told], (np.arange(whole) * n * band.period)[told]
