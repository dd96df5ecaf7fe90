"""Torques that nobody logged: what the known loop makes of references and positions.

A digital PID answers the positions that it measured, and the log holds these: τ = PID(r − e) + tau_ff + c.
The constant c is what the integral held at the log's first sample. As elsewhere it is taken to carry the arm
there, c = Φ₀ p, so that (Φ − Φ₀) p = PID(r − e) + tau_ff gives p and c without any value of the robot file.
A servo without integral has no such constant. What the drive loses between command and torque is not
in such a torque: it then looks like something of the mechanics.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.coordinate import feedforward_of, motor_of, reference_of, switch_of, torque_of
from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.estimation.least_squares import solve_weighted
from pyident.logs.log import Log, LogError
from pyident.regression.equations import Block
from pyident.regression.reduced import reduce
from pyident.regression.regressor import regressor_blocks
from pyident.simulation.feedforward import carrying_rows, controller_torque, recoverable
from pyident.simulation.recorded import start_speed

UNSEEN = (  # with either kind of loop
    "it has no torque, which is taken from the robot's own loop: a drive that delays, clips or scales its "
    "torque (torque_delay, torque_saturation) cannot be told from something of the mechanics"
)
_START = (
    "; what the controller's integral held at the start is taken to carry the arm, so that what it held "
    "against friction or anything else looks like a constant torque (offset, asymmetric_coulomb)"
)


def with_loop_torque(robot: Robot, logs: Sequence[Log]) -> tuple[tuple[Log, ...], tuple[str, ...]]:
    """The logs, those without any torque with that of the robot's loop; and a sentence on each of them.

    A log without references, or of a robot without loop, stays as it is. Raises LogError where the loop is
    known but the log does not tell what it did.
    """
    bare = [log for log in logs if _lacks_torque(robot, log)]
    if not bare or (robot.controller is None and robot.servo is None):
        return tuple(logs), ()
    made = [_servo_torque(robot, log) if robot.servo else _answer(robot, log) for log in bare]
    if robot.servo is None:
        made = _carried(robot, made)
    filled = {id(old): new for old, new in zip(bare, made, strict=True)}
    notes = tuple(f"{log.source}: {UNSEEN}{'' if robot.servo else _START}" for log in bare)
    return tuple(filled.get(id(log), log) for log in logs), notes


def _lacks_torque(robot: Robot, log: Log) -> bool:
    names = [torque_of(k) for k, _ in robot.numbered]
    references = [reference_of(k) for k, _ in robot.numbered]
    return not any(name in log.frame for name in names) and all(name in log.frame for name in references)


def _servo_torque(robot: Robot, log: Log) -> Log:
    assert robot.servo is not None
    joints = [k for k, _ in robot.numbered]
    reference, e = (log.signals([name(k) for k in joints]) for name in (reference_of, motor_of))
    on = log.frame.reindex(columns=[switch_of(k) for k in joints]).fillna(1.0).to_numpy(float)
    time = log.signals(["time"])[:, 0]
    de = np.gradient(e, log.period, axis=0)
    return _filled(log, robot, robot.servo.torque(reference, e, de, on, time))


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
    return _filled(log, robot, controller_torque(robot.controller, reference, e) + added)


def _carried(robot: Robot, logs: Sequence[Log]) -> list[Log]:
    """With what the integrals held at the start, from all logs at once."""
    rows = [carrying_rows(robot, log, _speed(robot, log)) for log in logs]
    reduced = reduce(_blocks(robot, logs, rows), robot.coordinates, tuple(robot.linear_parameters))
    p = solve_weighted(reduced).p
    return [
        _filled(log, robot, log.signals(robot.torques) + Phi_0 @ p)
        for log, Phi_0 in zip(logs, rows, strict=True)
    ]


def _blocks(robot: Robot, logs: Sequence[Log], rows: Sequence[np.ndarray]) -> Iterator[Block]:
    for log, Phi_0 in zip(logs, rows, strict=True):
        part = condition(log, robot)
        for at, Phi in regressor_blocks(robot, part.motion):
            Phi[:, : len(Phi_0)] -= Phi_0
            use = part.use[at]
            yield Phi * use[:, :, None], part.target[at] * use


def _speed(robot: Robot, log: Log) -> np.ndarray:
    return start_speed(log, log.signals([reference_of(k) for k, _ in robot.numbered]))


def _filled(log: Log, robot: Robot, torque: np.ndarray) -> Log:
    columns = {torque_of(k): torque[:, k - 1] for k, _ in robot.numbered}
    return replace(log, frame=log.frame.assign(**columns))
