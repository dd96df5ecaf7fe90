"""What a servo makes of commands and measured positions, in a log or in a replica of it."""

from dataclasses import replace

import numpy as np

from flexmodels.coordinate import motor_of, reference_of, switch_of, torque_of
from flexmodels.robot import Robot
from pyident.logs.log import Log


def with_servo_torque(robot: Robot, log: Log) -> Log:
    """The log with the torques that the robot's servos give by its commands, positions and switches."""
    assert robot.servo is not None
    joints = [k for k, _ in robot.numbered]
    reference, e = (log.signals([name(k) for k in joints]) for name in (reference_of, motor_of))
    on = log.frame.reindex(columns=[switch_of(k) for k in joints]).fillna(1.0).to_numpy(float)
    time = log.signals(["time"])[:, 0]
    torque = robot.servo.torque(reference, e, np.gradient(e, log.period, axis=0), on, time)
    return replace(with_torque(robot, log, torque), by_servo=True)


def with_torque(robot: Robot, log: Log, torque: np.ndarray) -> Log:
    """The log with other torques (N, joints) [N m or N]."""
    columns = {torque_of(k): torque[:, k - 1] for k, _ in robot.numbered}
    return replace(log, frame=log.frame.assign(**columns))
