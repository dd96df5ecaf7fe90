"""What may be wrong of a torque that is logged, which no robot file states: its gain, its time."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pyident.conditioning.motion import Motion


@dataclass(frozen=True)
class Logged:
    """What may be wrong of a logged torque, which no robot file states.

    slope     (N,) of a joint's torque (N,), a motion and the joint (from 0): what the correction changes in a
              logged torque, per unit
    mend      how it is corrected in the mapping of the log;  by: the same of a correction that was found
    said      of a correction, after the torque's name
    """

    slope: Callable[[np.ndarray, Motion, int], np.ndarray]
    mend: str
    by: Callable[[int, float], str]
    said: Callable[[float], str]


def _by_a_share(value: float) -> str:
    return f" by about {value:.2g} of itself"


def _in_time(value: float) -> str:
    return f", about {1e3 * abs(value):.2g} ms {'late' if value > 0 else 'early'}"


def _scaled(torque: np.ndarray, _: Motion, __: int) -> np.ndarray:
    return -torque


def _later(torque: np.ndarray, motion: Motion, k: int) -> np.ndarray:
    """Minus the torque's rate; across a reversal, where friction makes it a step, that of one side."""
    if motion.time is None:
        return np.zeros_like(torque)
    forward = np.diff(torque) / np.diff(motion.time)
    one_way = motion.dq[1:, k] * motion.dq[:-1, k] > 0
    counted = np.zeros((2, len(torque)))
    counted[0, :-1], counted[1, 1:] = one_way, one_way
    rates = np.zeros((2, len(torque)))
    rates[0, :-1], rates[1, 1:] = forward, forward
    return -(counted * rates).sum(axis=0) / np.maximum(counted.sum(axis=0), 1)


GAIN = Logged(
    _scaled,
    "multiply joint{k}.tau by 1 + the correction that `diagnose` finds",
    lambda k, value: f"multiply joint{k}.tau by about {1 + value:.3g}",
    _by_a_share,
)
LAG = Logged(
    _later,
    "give joint{k}.tau the delay that `diagnose` finds",
    lambda k, value: f"give joint{k}.tau a delay of about {value:.2g} s",
    _in_time,
)
