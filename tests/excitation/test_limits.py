"""Where limits come from: what is given, then the robot's file, then its own experiment."""

from dataclasses import replace

import numpy as np
import pytest
from one_joint import one_joint
from planned_joint import limited

from flexmodels.joint import Limits
from flexmodels.robot import RobotError
from pyident.excitation.limits import limits_of


def test_what_is_given_stands_above_the_file():
    found = limits_of(limited(), {"joint1.speed": 1.25, "joint1.acceleration": 9.0})
    assert found.speed == pytest.approx([1.25])
    assert found.acceleration == pytest.approx([9.0])
    assert (found.lower[0], found.upper[0], found.torque[0]) == (-1.5, 1.5, 60.0)
    assert found.notes == ()


def test_joints_go_by_their_own_names_too():
    """Unless two of them share one, or it is another's number."""
    (joint,) = limited().joints
    elbow = replace(limited(), joints=(replace(joint, name="elbow"),))
    found = limits_of(elbow, {"elbow.speed": 1.25}, {"elbow": 0.3})
    assert (found.speed[0], found.home[0]) == (1.25, 0.3)
    odd = tuple(replace(joint, name=name) for name in ("joint2", "twin", "twin"))
    assert replace(elbow, joints=odd).joint_numbers == {"joint1": 1, "joint2": 2, "joint3": 3}


def test_the_own_experiment_fills_what_is_open_and_says_so():
    """swing/2 (1 - cos(w t)) of 1 rad in 0.4 s: speed w/2, acceleration w²/2, and 5 % more of each."""
    found = limits_of(one_joint())
    w = 2 * np.pi / 0.4
    assert found.upper == pytest.approx([1.05], abs=1e-6)
    assert found.lower == pytest.approx([-0.05], abs=1e-6)
    assert found.speed == pytest.approx([1.05 * w / 2], rel=2e-3)
    assert found.acceleration == pytest.approx([1.05 * w**2 / 2], rel=5e-3)
    assert len(found.notes) == 5


def test_an_acceleration_stays_open_where_a_torque_limits_it():
    found = limits_of(limited())
    assert np.isinf(found.acceleration).all()
    assert found.notes == ("nothing limits the acceleration of every joint",)


def test_a_joint_that_turns_without_end_keeps_within_half_a_turn():
    (joint,) = limited().joints
    endless = replace(joint, limits=Limits(speed=3.0, effort=60.0))
    robot = replace(limited(), joints=(endless,)).with_settings(identification=None)
    found = limits_of(robot, home={"joint1": 1.0})
    assert (found.lower[0], found.upper[0]) == pytest.approx((1.0 - np.pi, 1.0 + np.pi))
    assert found.notes[0].startswith("nothing limits the position of every joint: a motion stays within half")


def test_a_robot_of_which_nothing_is_known_is_refused():
    with pytest.raises(RobotError, match=r"no limit joint1\.lower"):
        limits_of(one_joint().with_settings(identification=None))


def test_narrower_limits_lie_about_home():
    narrow = limits_of(limited()).within(0.5, 0.25)
    assert (narrow.lower[0], narrow.upper[0], narrow.speed[0], narrow.torque[0]) == (-0.75, 0.75, 1.5, 15.0)
