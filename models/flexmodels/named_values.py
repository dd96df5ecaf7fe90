"""Numbers of a robot by name: its parameters, and those of its servos."""

from collections.abc import Mapping
from dataclasses import replace

from flexmodels.robot import Robot, RobotError
from flexmodels.settings.servo import PER_JOINT


def settable(robot: Robot) -> dict[str, float]:
    """Every parameter and every setting of the servos, by name."""
    return robot.parameters | (robot.servo.parameters if robot.servo else {})


def with_settings(robot: Robot, values: Mapping[str, float]) -> Robot:
    """The same robot with other numbers; `servo.kp` stands for that of every joint. Raises RobotError."""
    known = set(settable(robot))
    shared = {f"servo.{name}" for name in PER_JOINT} if robot.servo else set()
    for name in values:
        if name not in known | shared:
            stem = name.partition(".")[0]
            near = [other for other in sorted(known | shared) if other.startswith(stem)] or sorted(known)
            raise RobotError(f"robot {robot.name} has no parameter {name}; it has {', '.join(near[:12])} ...")
    of_servo = {name: v for name, v in values.items() if name not in robot.parameters}
    changed = robot.with_parameters({name: v for name, v in values.items() if name not in of_servo})
    if robot.servo is None or not of_servo:
        return changed
    return replace(changed, servo=robot.servo.with_parameters(of_servo))
