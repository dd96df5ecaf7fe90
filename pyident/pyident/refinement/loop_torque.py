"""Torques that nobody logged: what the known loop makes of references and positions.

A digital PID answers the positions that it measured, and the log holds these: τ = PID(r − e) + tau_ff + c.
The constant c is what the integral held at the log's first sample: weight, friction, the end of a motion
that was not logged. Nothing in the log tells it, so it is free, in every log and at every joint
(`up_to_constant`): equations then read differences from their mean alone. Into the column of the torque goes
the c under which their residual is zero on average, for laws of the torque and for figures. A servo without
integral has no such constant. What the drive loses between command and torque is not in such a torque: it
then looks like something of the mechanics.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.coordinate import feedforward_of, motor_of, reference_of, torque_of
from flexmodels.effects import signals
from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import weighted
from pyident.logs.log import Log, LogError
from pyident.regression.equations import Problem
from pyident.regression.regressor import generalised_forces
from pyident.simulation.feedforward import controller_torque, recoverable
from pyident.simulation.servo_torque import with_servo_torque, with_torque

_ROUNDS = 3  # a law of the torque needs its constant, and the constant the law's values
UNSEEN = (  # with either kind of loop
    "it has no torque, which is taken from the robot's own loop: a drive that delays, clips or scales its "
    "torque (torque_delay, torque_saturation, torque_droop), or has other gains than the robot file, cannot "
    "be told from something of the mechanics"
)
_START = (
    "; what the controller's integral held at the start nobody knows: a constant is free in every log, so "
    "that a constant torque (offset, the Coulomb part of asymmetric_coulomb) cannot be seen"
)


def with_loop_torque(robot: Robot, logs: Sequence[Log]) -> tuple[tuple[Log, ...], tuple[str, ...]]:
    """The logs, those without any torque with that of the robot's loop; and a sentence on each of them.

    A log without references, or of a robot without loop, stays as it is. Raises LogError where the loop is
    known but the log does not tell what it did.
    """
    bare = [log for log in logs if lacks_torque(robot, log)]
    if not bare or (robot.controller is None and robot.servo is None):
        return tuple(logs), ()
    made = [with_servo_torque(robot, log) if robot.servo else _answer(robot, log) for log in bare]
    if robot.servo is None:
        made = _centred(robot, made)
    filled = {id(old): new for old, new in zip(bare, made, strict=True)}
    notes = tuple(f"{log.source}: {UNSEEN}{'' if robot.servo else _START}" for log in bare)
    return tuple(filled.get(id(log), log) for log in logs), notes


def lacks_torque(robot: Robot, log: Log) -> bool:
    """Whether a log has no torque and all references, of which the robot's loop makes one."""
    names = [torque_of(k) for k, _ in robot.numbered]
    references = [reference_of(k) for k, _ in robot.numbered]
    return not any(name in log.frame for name in names) and all(name in log.frame for name in references)


def _answer(robot: Robot, log: Log) -> Log:
    """With what the controller answers, its integral from zero on."""
    assert robot.controller is not None
    joints = [k for k, _ in robot.numbered]
    missing = [feedforward_of(k) for k in joints if feedforward_of(k) not in log.frame]
    if missing:
        raise LogError(
            f"{log.source}: it has neither torques nor {missing[0]}; without torques the feed-forward must "
            "be in the log (a column of zeros where there is none)"
        )
    if not recoverable(robot, log):
        raise LogError(
            f"{log.source}: it has no torques, and its {1 / log.period:g} samples a second are not those of "
            f"the controller ({robot.controller.rate:g}), which could tell them; log at that rate"
        )
    reference, e, added = (
        log.signals([name(k) for k in joints]) for name in (reference_of, motor_of, feedforward_of)
    )
    return with_torque(robot, log, controller_torque(robot.controller, reference, e) + added)


def _centred(robot: Robot, logs: Sequence[Log]) -> list[Log]:
    """With the constants that all equations of the logs ask for together, which stay free.

    In rounds, as a law of the robot may read the torque.
    """
    logs = [replace(log, up_to_constant=robot.torques) for log in logs]
    for _ in range(_ROUNDS):
        parts = [condition(log, robot) for log in logs]
        best = weighted(Problem(robot, tuple(parts)))
        missing = [_constants(best.problem.robot, part, best.solution.p) for part in parts]
        logs = [
            with_torque(robot, log, log.signals(robot.torques) + c)
            for log, c in zip(logs, missing, strict=True)
        ]
        if not _reads_torque(robot):
            break
    return logs


def _reads_torque(robot: Robot) -> bool:
    laws = [law for joint in robot.joints for law in joint.effects]
    return any(signals.tau in law.symbols for law in laws)


def _constants(robot: Robot, part: Conditioned, p: np.ndarray) -> np.ndarray:
    """(joints,) mean of what the equations in use need beyond the torques, under p (P,)."""
    left = (generalised_forces(robot, part.motion, p) - part.target) * part.use
    joints = slice(0, len(robot.joints))
    return left.sum(axis=0)[joints] / np.maximum(part.use.sum(axis=0)[joints], 1.0)
