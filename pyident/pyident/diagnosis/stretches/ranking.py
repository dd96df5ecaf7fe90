"""The laws in the order of what each takes of one stretch of one equation's residual.

    share = (E_own − E_law) / (E_own − E_replicas)

with E the mean square over the stretch: of the residual under new values of the model's own laws, of the same
with one law more, and of what replicas leave. A share is of that stretch alone and no verdict: a law that
takes it may imitate what is missing (`diagnose` judges on all equations and on held-out logs).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyident.comparison.traces import Trace
from pyident.diagnosis.stretches.waves import LawWave, Waves
from pyident.logs.log import LogError
from pyident.rules.bins import BINS


@dataclass(frozen=True)
class Share:
    """What a law takes of a stretch.

    percent     of what exceeds the floor there, once the model's own laws have taken theirs
    waveform    (N,) what it takes, along the whole trace;  left: (N,) the residual that remains with it
    tied        whether it differs from the best one by less than replicas would show
    """

    law: LawWave
    percent: float
    waveform: np.ndarray
    left: np.ndarray
    tied: bool = False

    @property
    def shown(self) -> float:
        """In per cent, for a reader: what leaves less than replicas takes all, what adds takes nothing."""
        return min(max(self.percent, 0.0), 100.0)


@dataclass(frozen=True)
class Ranking:
    """Of one stretch. own_percent: what new values of the model's own laws take of its excess.

    band         of frequencies [Hz] that count, None: all that are shown
    over_floor   rms of the residual there, over that of replicas: from 1 on there is something to explain
    own_leaves   the same of what those new values leave: from 1 on there is something for a law
    """

    coordinate: str
    log: str
    span: tuple[float, float]
    band: tuple[float, float] | None
    over_floor: float
    own_percent: float
    own_leaves: float
    shares: tuple[Share, ...]

    @property
    def tie(self) -> tuple[Share, ...]:
        """The best and what these logs cannot tell from it."""
        return tuple(s for s in self.shares if s.tied)


def ranking(waves: Waves, trace: Trace, span: tuple[float, float] | None = None) -> Ranking:
    """Of a trace's residual within a span of time [s]; None: all of it. Raises LogError."""
    span = span or (float(trace.time[0]), float(trace.time[-1]))
    at = (trace.time >= span[0]) & (trace.time <= span[1]) & trace.used
    if not at.any():
        raise LogError(f"{trace.coordinate} of {trace.log} has no samples from {span[0]:g} to {span[1]:g} s")
    key = trace.log, trace.coordinate
    refitted = trace.passed(waves.refitted[key].astype(float))
    floor = float(np.mean(_replicas_square(trace)[at]))
    before, own = float(np.mean(trace.residual[at] ** 2)), float(np.mean(refitted[at] ** 2))
    shares = []
    for law in waves.laws:
        if key in law.taken:
            taken = trace.passed(law.taken[key].astype(float))
            left = refitted - taken
            percent = 100 * (own - float(np.mean(left[at] ** 2))) / max(own - floor, 1e-9 * own, 1e-300)
            shares.append(Share(law, percent, taken, left))
    shares.sort(key=lambda share: -share.percent)
    over_floor, own_leaves = (float(np.sqrt(x / max(floor, 1e-300))) for x in (before, own))
    own_percent = 100 * (before - own) / max(before - floor, 1e-9 * before, 1e-300)
    tied = _tied(shares, at, floor)
    return Ranking(trace.coordinate, trace.log, span, trace.band, over_floor, own_percent, own_leaves, tied)


def _tied(shares: Sequence[Share], at: np.ndarray, floor: float) -> tuple[Share, ...]:
    """With those marked whose waveform replicas could not tell from the best one's."""
    out = []
    for share in shares:
        apart = float(np.mean((share.waveform - shares[0].waveform)[at] ** 2))
        out.append(Share(share.law, share.percent, share.waveform, share.left, apart <= floor))
    return tuple(out)


def _replicas_square(trace: Trace) -> np.ndarray:
    """(N,) mean square of the replicas, from their ribbon."""
    return ((trace.high + trace.low) / 2) ** 2 + ((trace.high - trace.low) / 2 / BINS.ribbon) ** 2
