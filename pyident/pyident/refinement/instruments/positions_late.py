"""How late all positions came against the torques: one more unknown of the instrumental estimate.

A drive's current passes a filter, an encoder's angle another bus: late by L the positions miss the torques by
L times the rate of these. A millisecond is enough for friction to be found many of its standard deviations
off. So the rates stand beside Φ, with the simulated rates as instruments, for each joint and each half of the
logs by itself; and where all that tell agree on a time that is not chance, the positions belong there. Of a
motion that lost its noise, what else it lost may pass for a delay: the motion as it was measured must tell of
it, too. What makes a single torque late, as a law with a memory does, says nothing of a clock: without any
one joint the others must tell of it, too. One joint alone is believed where its time is half a sample: a
command that is held from its sample on, or was held until it, is early or late by that. Where they agree on
nothing that is sure, the time may still be one that matters, and the parameters are known as badly as that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from flexmodels.robot import Robot
from pyident.conditioning.alignment import is_half
from pyident.conditioning.weak_form import condition
from pyident.estimation.instrumental_variables import MomentEquations, Rows, products
from pyident.estimation.least_squares import Solution
from pyident.logs.foreign import delayed
from pyident.logs.log import Log
from pyident.refinement.instruments.logged import quiet
from pyident.refinement.instruments.residual_spectrum import spectral
from pyident.refinement.instruments.simulated_rows import Repeated, every, in_memory
from pyident.simulation.replica import Repeat

_SURE = 3.0  # standard deviations, of the time from zero
_ALIKE = 0.2  # of the time: as far as joints differ beside chance
_PARTS = 2  # of the logs, one after the other
_WITHOUT = 2.0  # standard deviations, of the time that is left without any one joint
_USUAL = 0.5  # samples: what is known of a clock before it is asked
_LONGEST = 5.0  # samples: more is no matter of a clock
_STEP = 0.5  # samples on either side of a rate


@dataclass(frozen=True)
class Late:
    """time, std [s] by which all positions came late (early: below 0); slope (P,): parameters per second.

    sure   whether it is no chance; else nothing is moved, and std is how far from zero it may be
    """

    time: float
    std: float
    slope: np.ndarray
    sure: bool

    @property
    def variance(self) -> np.ndarray:
        """(P, P) of the parameters, by what is not known of the time."""
        return self.std**2 * np.outer(self.slope, self.slope)


def positions_late(
    logs: Repeated,
    frames: Sequence[pd.DataFrame],
    rows: Sequence[Rows],
    equations: MomentEquations,
    solution: Solution,
) -> Late | None:
    """What the logs tell of it beside their solution; None where joints differ, or too few tell.

    frames   of the simulations that the instruments are from
    """
    wider = _with_every_rate(logs, frames, rows)
    found = [_late(wider, logs, equations, solution)]
    if quiet(logs.robot):
        pairs = zip(wider, logs.again, strict=True)
        measured = [_as_measured(logs.robot, own, again) for own, again in pairs]
        found.append(_late(measured, logs, equations, solution))
    told = [late for late in found if late is not None]
    return min(told, key=lambda late: (late.sure, -late.std)) if len(told) == len(found) else None


def _late(wider: list[Rows], logs: Repeated, equations: MomentEquations, solution: Solution) -> Late | None:
    """What rows with rates tell; None as in `positions_late`."""
    try:
        found = _times(wider, equations, solution, _PARTS * len(logs.robot.joints))
    except np.linalg.LinAlgError:  # as of logs without any noise, or joints that never turn round
        return None
    return None if found is None else _common(*found, max(a.log.period for a in logs.again))


def _with_every_rate(logs: Repeated, frames: Sequence[pd.DataFrame], rows: Sequence[Rows]) -> list[Rows]:
    """Each log's rows with a column for every torque's rate in each part of the logs."""
    ends = np.cumsum([len(own.y) for own in rows])
    parts = np.split(_PARTS * np.arange(ends[-1]) // ends[-1], ends[:-1])
    pairs = zip(rows, logs.again, frames, parts, strict=True)
    return [_with_rates(logs.robot, own, again.log, frame, part) for own, again, frame, part in pairs]


def _times(
    wider: list[Rows], equations: MomentEquations, solution: Solution, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """Times (C,) of those of `count` rates that tell, covariance (C, C), slopes (P, C), numbers of joints."""
    P, weights, r = len(solution.p), solution.weights, solution.rank
    sums = products(every(wider), weights)
    told = [P + k for k in range(count) if sums[P + k, P + k] > 0]
    if len(told) < _PARTS:
        return None
    turn, span = equations.turn[:, :r], equations.Vt[:r].T / equations.scale[:, None]
    B = turn.T @ sums[:P, :P] @ span
    free = np.zeros((P + count, len(told)))  # of what the parameters take up
    free[:P] = -turn @ np.linalg.solve(B.T, (sums[told, :P] @ span).T)
    free[told, range(len(told))] = 1.0
    spread = np.linalg.inv(free.T @ sums[:, told])
    p = np.append(solution.p, np.zeros(count))
    scores = sum(own.moments(own.residual(p), weights) for own in wider) @ free
    fitted = np.concatenate([equations.turn, np.zeros((count, equations.turn.shape[1]))])
    covariance = spread @ spectral(every(wider), weights, fitted=fitted)(free, p) @ spread.T
    slopes = -span @ np.linalg.solve(B, turn.T @ sums[:P, told])
    return spread @ scores, covariance, slopes, (np.array(told) - P) // _PARTS


def _common(
    times: np.ndarray, covariance: np.ndarray, slopes: np.ndarray, joints: np.ndarray, period: float
) -> Late:
    """Of times (C,) of joints (C,) and parts, their covariance (C, C) and slopes (P, C)."""
    time, std = _mean(times, covariance)
    each = np.sqrt(np.diag(covariance))
    if abs(time) > _LONGEST * period or (np.abs(times - time) > _SURE * each + _ALIKE * abs(time)).any():
        return Late(0.0, _USUAL * period, slopes.sum(axis=1), False)  # joints differ: as before one was asked
    others = [joints != joint for joint in np.unique(joints)]
    without = [_mean(times[kept], covariance[np.ix_(kept, kept)]) for kept in others if kept.any()]
    agree = (np.sign(time) * t > _WITHOUT * s for t, s in without)
    borne_out = all(agree) if without else is_half(abs(time), period)
    sure = abs(time) > _SURE * std and borne_out
    if not sure:
        std = float(
            np.hypot(std, time) if abs(time) > _WITHOUT * std else (std**-2 + (_USUAL * period) ** -2) ** -0.5
        )
    return Late(time, std, slopes.sum(axis=1), sure)


def _mean(times: np.ndarray, covariance: np.ndarray) -> tuple[float, float]:
    """The time that times of a covariance agree on, and its standard deviation."""
    weights = np.linalg.solve(covariance, np.ones(len(times)))
    return float(weights @ times / weights.sum()), float(weights.sum() ** -0.5)


def _as_measured(robot: Robot, wider: Rows, again: Repeat) -> Rows:
    """Rows with all that their log has of the motion, noise included."""
    A = in_memory(robot, condition(again.log, robot)).A
    return replace(wider, A=np.concatenate([A, wider.A[:, :, A.shape[2] :]], axis=2))


def _with_rates(robot: Robot, rows: Rows, log: Log, frame: pd.DataFrame, part: np.ndarray) -> Rows:
    """A log's rows with its torques' rates as further columns; the simulation's for them.

    part   (N,) to which each of its samples belongs
    """
    A, Z = (
        np.concatenate([matrix, _columns(robot, of, rows.y.shape, part)], axis=2)
        for matrix, of in ((rows.A, log), (rows.Z, Log(frame, "simulation")))
    )
    return Rows(A, Z, rows.y, rows.share)


def _columns(robot: Robot, log: Log, shape: tuple[int, ...], part: np.ndarray) -> np.ndarray:
    """(N, n, joints x parts) each joint's rate on its own equation in each part [N m/s]."""
    half, names = _STEP * log.period, robot.torques
    logged, ends = [name for name in names if name in log.frame], []
    for step in (half, -half):
        moved = condition(Log(delayed(log.frame, dict.fromkeys(logged, step)), log.source), robot)
        ends.append(moved.target[:: moved.thinning])
    rate = (ends[0] - ends[1]) / (2 * half)
    out = np.zeros((*shape, _PARTS * len(names)))
    for k in range(len(names)):
        out[np.arange(len(part)), k, _PARTS * k + part] = rate[:, k]
    return out
