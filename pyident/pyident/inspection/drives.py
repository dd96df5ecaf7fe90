"""Torques that come as a current, a voltage, counts or parts of a rated value: what is asked of them.

The question, the line of the mapping and its arithmetic are of one and the same unit: A and V whatever the
prefix in the file, 100 % of what comes in % or ‰, else one unit of the column.
"""

import numpy as np

from flexmodels.robot import Robot
from pyident.inspection.channel import Channel
from pyident.logs.units import RATED


def knows_drive(robot: Robot, c: Channel) -> bool:
    """Whether the robot file says what a motor's current gives."""
    known = robot.transmission is not None and robot.transmission.drive is not None
    return known and c.signal == "current" and c.side == "motor" and c.unit in ("A", "mA")


def of_its_drive(c: Channel) -> str:
    """The question of what a column gives as a torque."""
    if c.unit in RATED:
        return (
            f"how many {_given(c)} are 100 % of {c.column} (its rated value), and is it of the motor or of "
            "the joint? (rated, gear)"
        )
    if c.signal == "voltage":
        return (
            f"{c.column} is a voltage or duty: it is not needed where the robot file has a [servo]; "
            f"otherwise, how many N m (or N) does one {_unit(c)} give? (drive)"
        )
    return (
        f"how many N m (or N) does one {_unit(c)} of {c.column} give, and at the motor or at the joint? "
        "(drive, gear)"
    )


def drive_line(c: Channel) -> str:
    """The line of the mapping that holds the answer, with what it is per."""
    if c.unit in RATED:
        return f"rated = 1.0  # ? {_given(c)} at 100 % of the column"
    per = "unit of the column" if _unit(c) == "unit" else _unit(c)
    return f"drive = 1.0  # ? N m (or N) per {per}"


def _given(c: Channel) -> str:
    return "A" if c.name is not None and c.name.endswith(".current") else "N m (or N)"


def _unit(c: Channel) -> str:
    if c.unit is not None and c.unit[-1] in "AV":
        return c.unit[-1]
    whole = bool((c.values == np.round(c.values)).all()) and float(np.nanmax(np.abs(c.values))) > 1
    return "count" if whole else "unit"
