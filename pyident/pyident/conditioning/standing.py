"""Joints that stand still during a whole log."""

from collections.abc import Sequence

import numpy as np

from flexmodels.coordinate import joint_name, motor_of
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.logs.disk import LogFile
from pyident.logs.log import Log
from pyident.rules.equation_checks import EQUATIONS

_WINDOW = 100_000  # rows of a log on disk that are in memory at a time


def standing(robot: Robot, logs: Sequence[Log | LogFile]) -> list[str]:
    """A sentence on the joints that stand still, and on what follows from that.

    Raises LogError for a log without positions.
    """
    still = [joint_name(k) for k in standing_joints(np.max([_way(robot, log) for log in logs], axis=0))]
    if not still:
        return []
    stand = "stands" if len(still) == 1 else "stand"
    where = logs[0].source if len(logs) == 1 else "all logs"
    return [
        f"{', '.join(still)} {stand} still in {where}: friction may hold any torque there, so nothing is "
        "said of a motor's own friction and inertia, nor of an axis"
    ]


def standing_joints(way: np.ndarray) -> list[int]:
    """Those, from 1, that go nowhere beside the busiest one; way: (joints,) how far each goes."""
    return (np.flatnonzero(way <= EQUATIONS.stands * way.max()) + 1).tolist()


def stands(way: np.ndarray, positions: np.ndarray) -> bool:
    """Whether a joint, or a sum of several, (N,) goes nowhere beside the busiest of positions (N, joints)."""
    return bool(np.ptp(way) <= EQUATIONS.stands * np.ptp(positions, axis=0).max())


def standing_in(motions: Sequence[Motion], joints: int) -> list[int]:
    """Joints, from 1, that stand still in each motion, wherever in it."""
    return standing_joints(np.max([np.ptp(motion.q[:, :joints], axis=0) for motion in motions], axis=0))


def _way(robot: Robot, log: Log | LogFile) -> np.ndarray:
    """(joints,) how far each goes [rad or m]."""
    names = [motor_of(k) for k, _ in robot.numbered]
    if isinstance(log, Log):
        return np.ptp(log.signals(names), axis=0)
    ends = [(w.values.min(axis=0), w.values.max(axis=0)) for w in log.windows(names, _WINDOW, 0)]
    return np.max([high for _, high in ends], axis=0) - np.min([low for low, _ in ends], axis=0)
