"""What a page draws of robots: the arm in 3D, standing or along a log."""

from pyident.report.moving_arm import MovingArm as MovingArm
from pyident.report.moving_arm import script as arm_script
from pyident.report.moving_arm import still
from pyident.verbs.inputs import Model, robot_of

__all__ = ["MovingArm", "arm_script", "standing_arm"]


def standing_arm(model: Model) -> MovingArm:
    """A robot in its zero pose. Raises RobotError."""
    return still(robot_of(model))
