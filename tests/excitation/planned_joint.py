"""A robot of one joint with limits, and how it is asked for a motion."""

from dataclasses import replace

from one_joint import one_joint

from flexmodels.joint import Limits
from flexmodels.robot import Robot

ALLOWED = Limits((-1.5, 1.5), 3.0, 60.0)
FEW = {"duration": 3.0, "evaluations": 30, "floor": None}


def limited(effort: float = 60.0) -> Robot:
    """`one_joint` whose file says what it may do."""
    robot = one_joint()
    (joint,) = robot.joints
    return replace(robot, joints=(replace(joint, limits=replace(ALLOWED, effort=effort)),))
