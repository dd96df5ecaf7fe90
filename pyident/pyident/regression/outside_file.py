"""What may be wrong that no robot file states: the scales of a log, a torque's time, a drive that bends."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.loads.bodies import carried_loads
from pyident.regression.loads.forces import as_they_are, link_forces_along
from pyident.regression.loads.swinging_drive import Springs, carry, swung
from pyident.regression.regressor import generalised_forces

_SLOPE = 0.2  # of a torque: beyond it the wrong one has bent all that its column is made of
_STEP = 1e-6  # rad, the largest bend; and of a position's scale


@dataclass(frozen=True)
class Outside:
    """What may be wrong and stands in no robot file.

    column    row -> (N,), what the correction changes in the torques, per unit; of a robot, a motion, a joint
              (from 1), and the springs about which it is asked for, none: the slope
    mend      where it is put right instead;  by: the same of a joint and a correction that was found
    said      of a joint's name and a correction, with its unit there, as `by`
    """

    column: Callable[[Robot, Motion, int, Springs], dict[int, np.ndarray]]
    mend: str
    by: Callable[[int, float, str], str]
    said: Callable[[str, float, str], str]


def _gain_said(joint: str, value: float, _: str) -> str:
    """The true torque is the logged one times 1 + value; a factor of all torques is one of all bodies."""
    which = "small" if value > 0 else "large"
    amount = "far" if abs(value) > _SLOPE else f"{_off(value):.2g} %"
    off = f"its logged torque is {amount} too {which} against the other joints'"
    return f"the gain (torque constant) of {joint}, {off}"


def _gain_mended(k: int, value: float, _: str) -> str:
    if abs(value) > _SLOPE:
        where = f"the factor of joint{k}.tau in the mapping of the logs"
        return f"look up {where}: it is far from right, and how far the logs do not tell"
    return f"multiply joint{k}.tau by about {1 + value:.3g}, in the mapping of the logs"


def _off(gain: float) -> float:
    """Of the true torque [%]."""
    return 100 * abs(1 / (1 + gain) - 1)


def _ratio_said(joint: str, value: float, _: str) -> str:
    """The true position is the logged one times 1 + value."""
    which = "small" if value > 0 else "large"
    return f"the gear ratio of {joint}, its logged position is {_off(value):.2g} % too {which}"


def _lag_said(joint: str, value: float, _: str) -> str:
    return f"the logged torque of {joint}, about {1e3 * abs(value):.2g} ms {'late' if value > 0 else 'early'}"


def _answer_said(joint: str, value: float, _: str) -> str:
    """A torque that seems early was computed with too short a delay."""
    off = f"{1e3 * abs(value):.2g} ms too {'long' if value > 0 else 'short'}"
    return f"the delay of {joint}'s servo, about {off}"


def _answer_mended(k: int, value: float, _: str) -> str:
    which = "lower" if value > 0 else "raise"
    return f"{which} servo.delay by about {1e3 * abs(value):.2g} ms, in the robot file"


def _bend_said(joint: str, value: float, unit: str) -> str:
    """How far a slider's belt stretches hangs on how much of the mass is its motor's, which no log tells."""
    if not unit.startswith("rad"):
        return f"that {joint} is rigid: its belt or spindle stretches"
    return f"that {joint} is rigid: its drive bends, by about {value:.2g} {unit}"


def _bend_mended(k: int, value: float, unit: str) -> str:
    """Of a revolute joint a hinge is found by its motor, too."""
    encoder = "log where the link is, by an encoder behind the drive"
    if not unit.startswith("rad") or value <= 0:
        return encoder
    return (
        f"{encoder}, or give joint{k} a hinge, with k = [{1 / value:.2g}] in the robot file: `identify` then "
        "finds its stiffness and damping, and the inertia of its motor"
    )


def _torque(robot: Robot, motion: Motion, k: int) -> np.ndarray:
    """(N,) of joint k, by the robot's own parameters."""
    p = np.array(list(robot.linear_parameters.values()))
    return generalised_forces(robot, motion, p)[:, k - 1]


def _scaled(robot: Robot, motion: Motion, k: int, _: Springs) -> dict[int, np.ndarray]:
    return {k - 1: -_torque(robot, motion, k)}


def _stretched(robot: Robot, motion: Motion, k: int, _: Springs) -> dict[int, np.ndarray]:
    """The links' torques where joint k turns further than it logs; its own laws only change their values."""
    own = (_STEP * rate[:, k - 1] for rate in (motion.q, motion.dq, motion.ddq))
    other = link_forces_along(robot, _further(motion, k, *own))
    return dict(enumerate((other - as_they_are(robot, motion)) / _STEP))


def _later(robot: Robot, motion: Motion, k: int, _: Springs) -> dict[int, np.ndarray]:
    """Minus the torque's rate; across a reversal, where friction makes it a step, that of one side."""
    torque = _torque(robot, motion, k)
    if motion.time is None:
        return {k - 1: np.zeros_like(torque)}
    forward = np.diff(torque) / np.diff(motion.time)
    one_way = motion.dq[1:, k - 1] * motion.dq[:-1, k - 1] > 0
    counted = np.zeros((2, len(torque)))
    counted[0, :-1], counted[1, 1:] = one_way, one_way
    rates = np.zeros((2, len(torque)))
    rates[0, :-1], rates[1, 1:] = forward, forward
    return {k - 1: -(counted * rates).sum(axis=0) / np.maximum(counted.sum(axis=0), 1)}


def _bent(robot: Robot, motion: Motion, k: int, about: Springs) -> dict[int, np.ndarray]:
    """The links' torques where link k lags its motor by the load it carries, per compliance of the drive.

    The log has the motor's angle q; the link is at q - c F, with its load F and a compliance c (Spong 1987).
    Rotors and their friction turn with the motor, so that nothing else changes. About a spring it is the
    whole change, over its compliance, with the load of the link where it is, to second order; where links
    swing, all that the last spring changes beside the others.
    """
    load = carried_loads(robot, motion)[:, k - 1]
    if motion.time is None or not load.any():
        return {k - 1: np.zeros(len(load))}
    own = about.get(k)
    if own is not None and own.swings:
        if not carry(robot, motion, about):
            return {k - 1: np.zeros(len(load))}
        others = {joint: spring for joint, spring in about.items() if joint != k}
        change = swung(robot, motion, about)
        if others:
            change -= swung(robot, motion, others)
        return dict(enumerate(change / own.compliance))
    compliance = _STEP / float(np.abs(load).max()) if own is None else own.compliance
    if own is not None:
        load = carried_loads(robot, _behind(motion, k, compliance * load))[:, k - 1]
    change = link_forces_along(robot, _behind(motion, k, compliance * load)) - as_they_are(robot, motion)
    return dict(enumerate(change / compliance))


def _behind(motion: Motion, k: int, bend: np.ndarray) -> Motion:
    """The motion with the angle of joint k behind by a bend (N,) [rad]."""
    assert motion.time is not None
    rate = np.gradient(bend, motion.time)
    return _further(motion, k, -bend, -rate, -np.gradient(rate, motion.time))


def _further(motion: Motion, k: int, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> Motion:
    """The motion with joint k further by an angle, a speed and an acceleration, each (N,)."""
    moved = [rate.copy() for rate in (motion.q, motion.dq, motion.ddq)]
    for rate, own in zip(moved, (q, dq, ddq), strict=True):
        rate[:, k - 1] += own
    return replace(motion, q=moved[0], dq=moved[1], ddq=moved[2])


GAIN = Outside(
    _scaled,
    "multiply joint{k}.tau by 1 + the correction that `diagnose` finds, in the mapping of the log",
    _gain_mended,
    _gain_said,
)
RATIO = Outside(
    _stretched,
    "multiply joint{k}.e by 1 + the correction that `diagnose` finds, in the mapping of the log",
    lambda k, value, _: f"multiply joint{k}.e by about {1 + value:.4g}, in the mapping of the logs",
    _ratio_said,
)
LAG = Outside(
    _later,
    "give joint{k}.tau the delay that `diagnose` finds, in the mapping of the log",
    lambda k, value, _: f"give joint{k}.tau a delay of about {value:.2g} s, in the mapping of the logs",
    _lag_said,
)
ANSWER = Outside(
    _later, "change servo.delay by what `diagnose` finds, in the robot file", _answer_mended, _answer_said
)
BEND = Outside(
    _bent,
    "log where the link is, by an encoder behind the drive, or give joint{k} a hinge that `identify` finds",
    _bend_mended,
    _bend_said,
)
