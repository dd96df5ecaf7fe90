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
from pyident.diagnosis.base.projection import IMITATED, Base, Columns
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
    """Per log: row -> (E, K) whitened cosine and sine; over time with a phase of its own in each log."""
    out = []
    for i, (log, level) in enumerate(zip(logs, levels, strict=True)):
        X = np.column_stack(_waves(log, level, over, [at]))
        if over.kind == "frequency":
            wide = np.zeros((len(X), 2 * len(logs)))
            wide[:, 2 * i : 2 * i + 2] = X
            X = wide
        out.append({over.row: X})
    return out


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
        turning = _turning(log, Over("order", 0, column), [order])[0]
        waves = np.column_stack([np.real(turning), np.imag(turning)])
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


def _turning(log: Equations, over: Over, at: Sequence[float]) -> np.ndarray:
    """(F, N), cosine + i sine of each of several frequencies or orders an equal step apart."""
    motion = log.part.motion
    if over.kind == "frequency":
        assert motion.time is not None
        angle = 2 * np.pi * (motion.time - motion.time[0])
    else:
        angle = motion.q[:, over.column]
    z = np.empty((len(at), len(angle)), complex)
    z[0] = np.exp(1j * at[0] * angle)
    if len(at) > 1:
        step = np.exp(1j * (at[-1] - at[0]) / (len(at) - 1) * angle)
        for n in range(1, len(at)):
            np.multiply(z[n - 1], step, out=z[n])
    if over.kind != "misread":
        return z
    v, a, n = motion.dq[:, over.column], motion.ddq[:, over.column], np.array(at)[:, None]
    return (1j * n * a - n**2 * v**2) * z


def _waves(
    log: Equations, level: np.ndarray, over: Over, at: Sequence[float]
) -> tuple[np.ndarray, np.ndarray]:
    """(E, F) whitened cosines and sines on the equation."""
    z = log.part.used(over.row, _turning(log, over, at))
    whole = log.band.transform(np.concatenate([np.real(z), np.imag(z)]).T) / level[over.row][:, None]
    return whole[:, : len(at)], whole[:, len(at) :]


def _held(
    base: Base,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    over: Over,
    at: Sequence[float],
    rules: PeriodicRules,
) -> list[tuple[float, float]]:
    """Energy and amplitude at each of several frequencies or orders, an equal step apart.

    The amplitude is of a wave with that energy: coefficients of one that the base nearly imitates are not.
    What `projection.gains` says of `periodic_columns`, of many at once.
    """
    row, F, K = over.row, len(at), _freedom(logs, over)
    b, g, G = np.zeros((F, base.basis[0].shape[2], K)), np.zeros((F, K)), np.zeros((F, K, K))
    for i, (log, level) in enumerate(zip(logs, levels, strict=True)):
        first = 2 * i if over.kind == "frequency" else 0
        pair = _waves(log, level, over, at)
        for j, X in enumerate(pair):
            b[:, :, first + j] += X.T @ base.basis[i][row]
            g[:, first + j] += X.T @ base.residual[i][row]
            for k, Y in enumerate(pair):
                G[:, first + j, first + k] += np.einsum("ef,ef->f", X, Y)
    whole = np.maximum(np.trace(G, axis1=1, axis2=2), 1e-300)
    energy, left = _energies(G, G - b.transpose(0, 2, 1) @ b, g)
    return [
        (float(e), float(np.sqrt(2 * e / w))) if share >= rules.left else (0.0, 0.0)
        for e, w, share in zip(energy, whole, left, strict=True)
    ]


def _energies(full: np.ndarray, G: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`Gain.energy` and `Gain.left` (F,) of F sets of K columns.

    full, G   (F, K, K) products of whole columns, and of what the base leaves;  g: (F, K) with a residual
    """
    size = np.sqrt(np.maximum(np.diagonal(full, axis1=1, axis2=2), 1e-300))
    w, V = np.linalg.eigh(G / (size[:, :, None] * size[:, None, :]))
    part = np.einsum("fkj,fk->fj", V, g / size)
    told = w > IMITATED
    return np.where(told, part**2 / np.where(told, w, 1.0), 0.0).sum(axis=1), w[:, -1]


def _freedom(logs: Sequence[Equations], over: Over) -> int:
    return 2 * len(logs) if over.kind == "frequency" else 2


def _grid(logs: Sequence[Equations], over: Over, rules: PeriodicRules) -> np.ndarray:
    if over.kind == "frequency":
        longest = max(len(log.part.target) * log.band.period for log in logs)
        top = min(float(log.band.frequencies[-1]) for log in logs)
        return np.arange(2 * _PER_BIN, int(top * longest * _PER_BIN)) / longest / _PER_BIN
    lowest = lowest_order([log.part.motion.q[:, over.column] for log in logs])
    return np.arange(np.ceil(lowest), rules.highest_unexplained + 1)
