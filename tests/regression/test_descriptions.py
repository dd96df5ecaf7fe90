"""Columns of wrong descriptions against another library's mechanics; corrections of the robot file."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio_model import PinocchioRobot, mixed_robot, random_motion

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot, RobotError
from pyident.conditioning.motion import Motion
from pyident.regression.descriptions import (
    corrected,
    description_column,
    description_names,
    parsed,
    place_name,
)
from pyident.regression.regressor import regressor

H = 1e-4


@pytest.fixture(scope="module")
def robot():
    return mixed_robot(3)


@pytest.fixture(scope="module")
def motion(robot):
    q, dq, ddq = random_motion(robot, 60, 1)
    return Motion(q, dq, ddq, np.zeros((60, len(robot.joints))), np.arange(60.0))


def torques(robot: Robot, motion: Motion) -> np.ndarray:
    oracle = PinocchioRobot(robot)
    return np.array([oracle.inverse_dynamics(*x) for x in zip(motion.q, motion.dq, motion.ddq, strict=True)])


def slope(change, robot: Robot, motion: Motion) -> np.ndarray:
    return (torques(change(robot, H), motion) - torques(change(robot, -H), motion)) / (2 * H)


def column(robot: Robot, joint: int, name: str, motion: Motion) -> np.ndarray:
    return np.column_stack(list(description_column(robot, joint, name, motion).values()))


def with_joint(robot: Robot, k: int, **changes) -> Robot:
    joint = replace(robot.joints[k - 1], **changes)
    return replace(robot, joints=(*robot.joints[: k - 1], joint, *robot.joints[k:]))


@pytest.mark.parametrize("k", [2, 3, 5])
def test_a_joint_elsewhere(robot, motion, k):
    def moved(robot, amount):
        x, y, z = robot.joints[k - 1].origin
        return with_joint(robot, k, origin=(x, y + amount, z))

    expected = slope(moved, robot, motion)
    np.testing.assert_allclose(
        column(robot, k, "origin[y]", motion), expected, atol=1e-6 * np.abs(expected).max()
    )


def test_an_axis_tilted(robot, motion):
    def tilted(robot, amount):
        R = robot.joints[3].triad
        c, s = np.cos(amount), np.sin(amount)
        x, y = R @ np.array([c, s, 0.0]), R @ np.array([-s, c, 0.0])  # about z'
        return with_joint(robot, 4, x=tuple(x.tolist()), y=tuple(y.tolist()))

    expected = slope(tilted, robot, motion)
    np.testing.assert_allclose(
        column(robot, 4, "axis[z]", motion), expected, atol=1e-6 * np.abs(expected).max()
    )


def test_a_base_that_is_not_level(robot, motion):
    def tilted(robot, amount):
        return replace(robot, gravity=(0.0, 9.81 * np.sin(amount), -9.81 * np.cos(amount)))  # about x

    expected = slope(tilted, robot, motion)
    np.testing.assert_allclose(
        column(robot, 1, "base_tilt[x]", motion), expected, atol=1e-6 * np.abs(expected).max()
    )


def test_an_encoder_that_reads_zero_elsewhere(motion, robot):
    """The torques of the shifted angle, but for what other bodies make of them as well."""
    k = 2
    shift = np.zeros(motion.q.shape[1])
    shift[k - 1] = H
    ends = [torques(robot, replace(motion, q=motion.q + side * shift)) for side in (1, -1)]
    expected = (ends[0] - ends[1]) / (2 * H)
    links = [i for i, name in enumerate(robot.linear_parameters) if name.startswith("link")]
    Phi = regressor(robot, motion).matrix[:, :, links].reshape(-1, len(links))
    difference = (expected - column(robot, k, "encoder_zero", motion)).ravel()
    left = difference - Phi @ np.linalg.lstsq(Phi, difference, rcond=None)[0]
    own = expected.ravel() - Phi @ np.linalg.lstsq(Phi, expected.ravel(), rcond=None)[0]
    assert np.linalg.norm(own) > 1e-2 * np.linalg.norm(expected)  # other bodies do not make it all
    assert np.linalg.norm(left) < 1e-5 * np.linalg.norm(own)


def test_a_torque_read_too_small(robot, motion):
    p = np.array(list(robot.linear_parameters.values()))
    whole = regressor(robot, motion).matrix @ p
    found = description_column(robot, 3, "torque_gain", motion)
    assert list(found) == [2]
    np.testing.assert_allclose(found[2], -whole[:, 2])
    with pytest.raises(RobotError, match=r"multiply joint3.tau by 1 \+ the correction"):
        corrected(robot, 3, "torque_gain", 0.02)


def test_a_joint_that_turns_further_than_it_logs(robot, motion):
    """The torques of the true motion less those of the logged one, but for other values of its own laws."""
    k = 2
    ends = []
    for side in (1, -1):
        scale = np.ones(motion.q.shape[1])
        scale[k - 1] += side * H
        ends.append(
            torques(robot, replace(motion, q=motion.q * scale, dq=motion.dq * scale, ddq=motion.ddq * scale))
        )
    expected = (ends[0] - ends[1]) / (2 * H)
    own = [i for i, name in enumerate(robot.linear_parameters) if name.startswith(f"joint{k}.")]
    Phi = regressor(robot, motion).matrix[:, :, own].reshape(-1, len(own))
    difference = (expected - column(robot, k, "gear_ratio", motion)).ravel()
    left = difference - Phi @ np.linalg.lstsq(Phi, difference, rcond=None)[0]
    assert np.linalg.norm(left) < 1e-5 * np.linalg.norm(expected)
    with pytest.raises(RobotError, match=r"multiply joint2.e by 1 \+ the correction"):
        corrected(robot, k, "gear_ratio", 0.01)


def test_a_torque_that_comes_late(robot, motion):
    time, k, late = np.linspace(0, 2, 2001), 3, 4e-3
    rates = np.linspace(2.0, 4.0, motion.q.shape[1])
    size, angles = np.where(motion.q.std(axis=0) > 0.3, 1.0, 0.05), np.outer(time, rates)
    course = Motion(
        size * np.sin(angles), size * rates * np.cos(angles), -size * rates**2 * np.sin(angles), None, time
    )
    p = np.array(list(robot.linear_parameters.values()))
    torque = regressor(robot, course).matrix[:, k - 1] @ p
    (row,) = (found := description_column(robot, k, "torque_lag", course))
    assert row == k - 1
    logged = np.interp(time - late, time, torque)
    turns = np.flatnonzero(np.diff(np.sign(course.dq[:, k - 1])))
    clear = np.ones(len(time), bool)
    for turn in turns:  # until the friction before it has been logged
        clear[turn - 1 : turn + 7] = False
    clear[:7] = False
    change = (logged - torque)[clear]
    assert len(turns) > 0
    assert np.linalg.norm(change - late * found[row][clear]) < 0.05 * np.linalg.norm(change)
    with pytest.raises(RobotError, match=r"give joint3.tau the delay that `diagnose` finds, in the mapping"):
        corrected(robot, 3, "torque_lag", 0.002)


def test_places_are_said_as_the_robot_file_says_them():
    arm = load_robot("tx40")
    assert parsed(arm, "joint3.origin[z]") == (3, "origin[z]")
    assert place_name(*parsed(arm, "base_tilt[y]")) == "base_tilt[y]"
    assert "base_tilt[z]" not in description_names(arm, 1)  # gravity does not see it
    for wrong in (
        "joint3.length",
        "origin[z]",
        "joint9.origin[z]",
        "joint1.base_tilt[x]",
        "joint3.origin[w]",
    ):
        with pytest.raises(RobotError):
            parsed(arm, wrong)
