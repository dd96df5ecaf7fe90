"""Periodic forces of unknown period: amplitude against the order of a joint's angle and against frequency.

For every order n of an angle the columns cos nφ, sin nφ are held against the residual like those of a
law, and for every frequency cos ωt, sin ωt, in each log with a phase of its own. A peak counts against
the median of its neighbours. An angle that is itself misread by s sin nφ enters the torque by its
second derivative, J s (n cos nφ φ'' − n² sin nφ φ'²); that form is tried beside the plain one, and
where it is found the error is put into every equation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from scipy.ndimage import percentile_filter
from scipy.optimize import minimize_scalar
from scipy.special import chdtrc, chdtri

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.conditioning.order_waves import lowest_order
from pyident.diagnosis.base.projection import Base, Columns, gains
from pyident.diagnosis.unexplained.smooth import whitened_columns
from pyident.regression.regressor import generalised_forces
from pyident.regression.spectrum import Equations
from pyident.rules.periodic import PeriodicRules

_STEP = 1e-6  # rad, of the differences
_PER_BIN = 2  # frequencies tried per resolved one
_TOGETHER = 32  # frequencies or orders at once

Kind = Literal["frequency", "order", "misread"]


@dataclass(frozen=True)
class Over:
    """What a force may be periodic in: the time of each log or an angle of one joint.

    row      equation on which it acts;  column: of the angle in `Motion.q`, of no use for a frequency
    """

    kind: Kind
    row: int
    column: int = 0


@dataclass(frozen=True)
class Spectrum:
    """at (F,) [Hz or per turn], amplitude (F,) [N m; kg m² rad where misread], energy, background (F,)."""

    over: Over
    at: np.ndarray
    amplitude: np.ndarray
    energy: np.ndarray
    background: np.ndarray


@dataclass(frozen=True)
class Peak:
    """at [Hz or per turn];  p_value: of such a peak anywhere in its spectrum."""

    over: Over
    at: float
    amplitude: float
    energy: float
    p_value: float


def spectrum(
    base: Base, logs: Sequence[Equations], levels: Sequence[np.ndarray], over: Over, rules: PeriodicRules
) -> Spectrum:
    """A residual's amplitudes over a grid of frequencies [Hz] or orders [per turn]."""
    at = _grid(logs, over, rules)
    if not len(at):  # an axis at rest passes no period
        return Spectrum(over, at, at, at, at)
    groups = [at[i : i + _TOGETHER].tolist() for i in range(0, len(at), _TOGETHER)]
    found = [pair for group in groups for pair in _held(base, logs, levels, over, group, rules)]
    energy, amplitude = np.array(found).T
    quiet = percentile_filter(energy, rules.quiet, rules.neighbours, mode="reflect")
    typical = quiet / chdtri(_freedom(logs, over), 1 - rules.quiet / 100)
    return Spectrum(over, at, amplitude, energy, np.maximum(typical, 1.0))


def highest(
    base: Base,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    found: Spectrum,
    rules: PeriodicRules,
) -> Peak | None:
    """The largest peak, between the grid's values [Hz or per turn]; None where there is no spectrum."""
    if not len(found.at):
        return None
    best = int(np.argmax(found.energy))
    step = float(np.diff(found.at).max()) if len(found.at) > 1 else 0.0
    middle = float(found.at[best])

    def missed(x: float) -> float:
        return -_held(base, logs, levels, found.over, [x], rules)[0][0]

    finer: Any = minimize_scalar(missed, bounds=(middle - step, middle + step), method="bounded")
    ((energy, amplitude),) = _held(base, logs, levels, found.over, [float(finer.x)], rules)
    p = float(chdtrc(_freedom(logs, found.over), energy / found.background[best])) * len(found.at)
    return Peak(found.over, float(finer.x), amplitude, energy, min(p, 1.0))


def periodic_columns(
    logs: Sequence[Equations], levels: Sequence[np.ndarray], over: Over, at: float
) -> Columns:
    """Per log: row -> (E, K) whitened cosine and sine."""
    return _columns_at(logs, levels, over, [at])[0]


def _columns_at(
    logs: Sequence[Equations], levels: Sequence[np.ndarray], over: Over, listed: Sequence[float]
) -> list[Columns]:
    """`periodic_columns` at several frequencies or orders, transformed together."""
    several: list[list[dict[int, np.ndarray]]] = [[] for _ in listed]
    for i, log in enumerate(logs):
        waves = np.hstack([_waves(log, over, at) for at in listed])
        whole = whitened_columns([waves], [log], [levels[i]], over.row)[0][over.row]
        for columns, X in zip(several, np.split(whole, len(listed), axis=1), strict=True):
            if over.kind == "frequency":
                wide = np.zeros((len(X), 2 * len(logs)))
                wide[:, 2 * i : 2 * i + 2] = X
                X = wide
            columns.append({over.row: X})
    return list(several)


def misread_columns(
    robot: Robot,
    p: np.ndarray,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    column: int,
    order: float,
) -> Columns:
    """Per log: every row -> (E, 2): what the torques lack per radian of an angle misread by cos nφ, sin nφ.

    By central differences of Φ p over the angle, its speed and acceleration.
    """
    out = []
    for log, level in zip(logs, levels, strict=True):
        motion, part = log.part.motion, log.part
        waves = _waves(log, Over("order", 0, column), order)
        v, a = motion.dq[:, column, None], motion.ddq[:, column, None]
        turned = np.column_stack([-waves[:, 1], waves[:, 0]])
        rates = (waves, order * turned * v, order * turned * a - order**2 * waves * v**2)
        missed = []
        for wave in range(2):
            ends = [
                _torques(robot, p, motion, column, [side * _STEP * r[:, wave] for r in rates])
                for side in (1, -1)
            ]
            missed.append((ends[0] - ends[1]) / (2 * _STEP))
        raw = np.stack(missed, axis=2)
        rows = range(raw.shape[1])
        out.append({c: log.band.transform(part.used(c, raw[:, c].T).T) / level[c][:, None] for c in rows})
    return out


def _torques(
    robot: Robot, p: np.ndarray, motion: Motion, column: int, change: Sequence[np.ndarray]
) -> np.ndarray:
    moved = [rate.copy() for rate in (motion.q, motion.dq, motion.ddq)]
    for rate, difference in zip(moved, change, strict=True):
        rate[:, column] += difference
    q, dq, ddq = moved
    return generalised_forces(robot, replace(motion, q=q, dq=dq, ddq=ddq), p)


def _waves(log: Equations, over: Over, at: float) -> np.ndarray:
    motion = log.part.motion
    if over.kind == "frequency":
        assert motion.time is not None
        phase = 2 * np.pi * at * (motion.time - motion.time[0])
        return np.column_stack([np.cos(phase), np.sin(phase)])
    q, v, a = (rate[:, over.column] for rate in (motion.q, motion.dq, motion.ddq))
    c, s = np.cos(at * q), np.sin(at * q)
    if over.kind == "order":
        return np.column_stack([c, s])
    return np.column_stack([-at * s * a - at**2 * c * v**2, at * c * a - at**2 * s * v**2])


def _held(
    base: Base,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    over: Over,
    at: Sequence[float],
    rules: PeriodicRules,
) -> list[tuple[float, float]]:
    """Energy and amplitude at each frequency or order.

    The amplitude is of a wave with that energy: coefficients of one that the base nearly imitates are not.
    """
    freedom = _freedom(logs, over)
    free = np.full(freedom, -np.inf), np.full(freedom, np.inf)
    listed = _columns_at(logs, levels, over, at)
    return [
        (g.energy, float(np.sqrt(2 * g.energy / _energy(X)))) if g.left >= rules.left else (0.0, 0.0)
        for g, X in zip(gains(base, listed, [free] * len(at)), listed, strict=True)
    ]


def _energy(X: Columns) -> float:
    """Of whole columns, cosines and sines."""
    return max(sum(float(np.square(x).sum()) for log in X for x in log.values()), 1e-300)


def _freedom(logs: Sequence[Equations], over: Over) -> int:
    return 2 * len(logs) if over.kind == "frequency" else 2


def _grid(logs: Sequence[Equations], over: Over, rules: PeriodicRules) -> np.ndarray:
    if over.kind == "frequency":
        longest = max(len(log.part.target) * log.band.period for log in logs)
        top = min(float(log.band.frequencies[-1]) for log in logs)
        return np.arange(2 * _PER_BIN, int(top * longest * _PER_BIN)) / longest / _PER_BIN
    lowest = lowest_order([log.part.motion.q[:, over.column] for log in logs])
    return np.arange(np.ceil(lowest), rules.highest_unexplained + 1)
