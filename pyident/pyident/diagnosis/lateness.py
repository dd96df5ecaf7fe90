"""Positions that all come late against the torques: another clock, a filter, a bus, or drives that all lag.

Late by d they miss the torques by d times the rate of these, at every joint, so that laws with a memory are
found at several joints, and what is missing besides drowns. The column is what moving the positions changes
in the equations, the time the one that leaves least of them. It has to take most of what exceeds the floor of
two joints, and more than of any replica, to be believed. It is judged at the frequencies of the motion: a
controller answers its encoder's noise later than a robot would. Positions and torques of a robot whose loop
is known belong together by its controller, and one joint alone cannot be told from a law.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from flexmodels.robot import Robot
from pyident.diagnosis.base.denoised import corners
from pyident.diagnosis.base.projection import (
    Base,
    Columns,
    gain,
    gains_over,
    others_of,
    residuals_of,
    solve_base,
)
from pyident.diagnosis.base.residual_over_floor import Examination, bands_of, whitened
from pyident.logs.foreign import delayed
from pyident.logs.log import Log
from pyident.regression.spectrum import Equations

_ANY = (np.full(1, -np.inf), np.full(1, np.inf))
_STEP = 0.5  # samples
_JOINTS = 2  # that must tell the same
_EXACT = 0.02  # of a sample
_SAMPLES = 5.0  # more is no matter of a clock, and no straight line


def lateness(ex: Examination) -> float:
    """Time [s] by which all positions come late (early: below 0); 0 where the logs do not tell."""
    setting = ex.setting
    joints = range(len(setting.robot.joints))
    if setting.simulates or len(joints) < _JOINTS:
        return 0.0
    period = max(log.period for log in setting.logs)
    moving = _in_motion(ex)
    X = _columns(ex, _STEP * period, moving)
    found = gain(ex.base, X)
    if found.energy <= max(gains_over(ex.base, X, others_of(ex.base, ex.replica_residuals), *_ANY)):
        return 0.0
    late = _best(ex, moving, _SAMPLES * period, _EXACT * period)
    data = _moved(ex, late)
    base = solve_base(data)
    told = [k for k in joints if _tells(ex, base, data, k, moving)]
    return late if len(told) >= _JOINTS else 0.0


def _best(ex: Examination, moving: Sequence[np.ndarray], furthest: float, exact: float) -> float:
    """The time [s] that leaves least, up to the furthest, late or early.

    Both are tried: at reversals, which a filter of the torques smears, the column may have the wrong sign.
    """
    found: list[Any] = [
        minimize_scalar(lambda t: _energy(ex, t, moving), bounds=bounds, options={"xatol": exact})  # pyright: ignore
        for bounds in ((-furthest, 0.0), (0.0, furthest))
    ]
    return float(min(found, key=lambda one: one.fun).x)


def _in_motion(ex: Examination) -> list[np.ndarray]:
    """Per log (n, E): where an equation's coordinate moves and is not noise alone."""
    robot = ex.setting.robot
    return [
        np.tile(e.band.frequencies, 2) <= corners(robot, log)[:, None]
        for e, log in zip(ex.logs, ex.setting.logs, strict=True)
    ]


def _moved(ex: Examination, late: float) -> list[Equations]:
    robot = ex.setting.robot
    return whitened(robot, all_earlier(robot, ex.setting.logs, late), ex.floors)


def _energy(ex: Examination, late: float, moving: Sequence[np.ndarray]) -> float:
    """What is left of an equation on average, over its floor."""
    residuals = [r[clear] for r, clear in zip(residuals_of(_moved(ex, late)), moving, strict=True)]
    return sum(float(np.square(r).sum()) for r in residuals) / sum(r.size for r in residuals)


def _columns(ex: Examination, step: float, moving: Sequence[np.ndarray]) -> Columns:
    """Per log what the equations of all joints miss per second that the positions come late."""
    found, p = [], ex.base.p
    for there, here, clear in zip(_moved(ex, step), ex.logs, moving, strict=True):
        change = ((there.y - there.A @ p) - (here.y - here.A @ p)) * clear
        found.append({k: -change[k][:, None] / step for k in range(len(ex.setting.robot.joints))})
    return found


def _tells(
    ex: Examination, base: Base, data: Sequence[Equations], k: int, moving: Sequence[np.ndarray]
) -> bool:
    """Whether joint k (from 0) lacks far less once the positions are where they belong."""
    rules, count = ex.setting.rules.search, sum(int(clear[k].sum()) for clear in moving)
    before, floor = ex.excess(ex.base.residual, _bands(ex.logs, k, moving), [k])
    after, _ = ex.excess(base.residual, _bands(data, k, moving), [k])
    chance = rules.chance * np.sqrt(2 * count)  # of the energy of noise, by its own floor
    return before - after > chance * floor / count and after < (1 - rules.explained[0]) * before


def _bands(logs: Sequence[Equations], k: int, moving: Sequence[np.ndarray]) -> list[np.ndarray]:
    """As `bands_of`, of what row k has in motion."""
    return [inside * clear[k][:, None] for inside, clear in zip(bands_of(logs), moving, strict=True)]


def earlier(robot: Robot, log: Log, late: float) -> Log:
    """The log with its positions where they belong if they came late [s], straight on where it ends."""
    if late == 0.0:
        return log
    lost = int(np.ceil(abs(late) / log.period))
    frame = delayed(log.frame, dict.fromkeys(robot.coordinates, late))
    values = frame[list(robot.coordinates)].to_numpy(copy=True)
    ends = values[::-1] if late > 0 else values  # the lost samples come first
    ends[:lost] = ends[lost] + np.arange(lost, 0, -1)[:, None] * (ends[lost] - ends[lost + 1])
    return replace(log, frame=frame.assign(**dict(zip(robot.coordinates, values.T, strict=True))))


def all_earlier(robot: Robot, logs: Sequence[Log], late: float) -> list[Log]:
    """Every log so."""
    return [earlier(robot, log, late) for log in logs]
