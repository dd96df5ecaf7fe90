"""A loop whose passive joints do not follow as its pin demands is refused."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio_model import PinocchioRobot, random_motion

from flexmodels.files.robot_file import load_robot
from flexmodels.loops.linkage_check import check_linkage
from flexmodels.robot import RobotError


def _parallelogram(**changes):
    robot = load_robot("parallelogram")
    rod = replace(robot.passive[0], **changes)
    return replace(robot, passive=(rod, *robot.passive[1:]))


def test_the_shipped_one_closes():
    """By Pinocchio's kinematics, which know nothing of the check's own."""
    robot = load_robot("parallelogram")
    check_linkage(robot)
    oracle, still = PinocchioRobot(robot), np.zeros(len(robot.coordinates))
    zero, moved = (
        oracle.nodes(q, still, still) for q in (still, random_motion(robot, 1)[0][0] * _motors(robot))
    )
    assert robot.closures
    for closure in robot.closures:
        ends = [moved[k - 1].x + moved[k - 1].R @ (closure.point - zero[k - 1].x) for k in closure.links]
        np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)
        assert np.linalg.norm(ends[0] - closure.point) > 0.01  # it has moved


def _motors(robot):
    """1 for the motors' angles, 0 for deformations: a pin holds where hinges do not bend."""
    return np.array([float(name.endswith(".e")) for name in robot.coordinates])


def test_a_joint_that_follows_the_wrong_way_opens_the_pin():
    first = load_robot("parallelogram").passive[0]
    reversed_ = {k: -factor for k, factor in first.follows.items()}
    with pytest.raises(RobotError, match=r"closure\[1\]: the pin opens by"):
        check_linkage(_parallelogram(follows=reversed_))


def test_a_rod_of_another_length_opens_the_pin():
    robot = load_robot("parallelogram")
    x, y, z = robot.passive[0].origin
    with pytest.raises(RobotError, match="the pin opens by"):
        check_linkage(_parallelogram(origin=(x + 0.05, y, z + 0.03)))


def test_a_pin_without_its_passive_joints():
    robot = load_robot("parallelogram")
    with pytest.raises(RobotError, match="two passive joints and one pin"):
        check_linkage(replace(robot, passive=robot.passive[:1]))
