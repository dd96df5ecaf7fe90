"""From when on a force is there: a step in time, where time is what a residual depends on.

A brake that drags, a screw that comes loose, a tool that is taken off: a force f, or a friction f sign(v), is
there after an instant of one log or of every log, and not before.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyident.diagnosis.base.projection import Base, Columns, gain, gains
from pyident.diagnosis.unexplained.smooth import Form, whitened_columns
from pyident.regression.spectrum import Equations

_INSTANTS = 60  # of the longest log, of a first look
_EDGE = 0.05  # of a log: what begins earlier or ends later than that is no change within it
_CLOSER = 4  # looks, each at a third of the distance


@dataclass(frozen=True)
class Change:
    """start [s], log its number, None for all; columns of the step, the energy these take, its size [N m]."""

    start: float
    log: int | None
    columns: Columns
    energy: float
    size: float


def sudden_change(
    base: Base, form: Form, logs: Sequence[Equations], levels: Sequence[np.ndarray], row: int
) -> Change | None:
    """The step [N m] that explains most of what a base leaves on an equation; None where logs are too short.

    levels   (n, E) of the floor, per log;  row: of the equation
    """

    def step(start: float, log: int | None) -> Columns:
        return whitened_columns(
            [_after(e, start, form, row) * (log in (None, k)) for k, e in enumerate(logs)], logs, levels, row
        )

    lasting = [len(e.part.target) * e.band.period for e in logs]
    distance = max(lasting) / _INSTANTS
    asked = [
        (float(start), log)
        for log in ([None] if len(logs) == 1 else [None, *range(len(logs))])
        for start in _instants(max(lasting) if log is None else lasting[log], distance)
    ]
    if not asked:
        return None
    for _ in range(_CLOSER):
        columns = [step(*which) for which in asked]
        energies = [
            found.energy
            for found in gains(base, columns, [(np.full(1, -np.inf), np.full(1, np.inf))] * len(asked))
        ]
        start, log = asked[int(np.argmax(energies))]
        distance /= 3
        asked = [(start + k * distance, log) for k in (-2, -1, 0, 1, 2)]
    best = step(start, log)
    found = gain(base, best)
    return Change(start, log, best, found.energy, float(found.coefficients[0]))


def _instants(length: float, distance: float) -> np.ndarray:
    return np.arange(_EDGE * length, (1 - _EDGE) * length, distance)


def _after(equations: Equations, start: float, form: Form, row: int) -> np.ndarray:
    """(N, 1) one after an instant, with the sign of the speed as friction."""
    part = equations.part
    after = np.arange(len(part.target)) * equations.band.period >= start
    sign = np.sign(part.motion.dq[:, row]) if form == "friction" else 1.0
    return (after * sign)[:, None]
