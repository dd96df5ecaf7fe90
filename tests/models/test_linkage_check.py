"""A loop whose passive joints do not follow as its pin demands is refused."""

from dataclasses import replace

import pytest

from flexmodels.files.robot_file import load_robot
from flexmodels.linkage_check import check_linkage
from flexmodels.robot import RobotError


def _parallelogram(**changes):
    robot = load_robot("parallelogram")
    rod = replace(robot.passive[0], **changes)
    return replace(robot, passive=(rod, *robot.passive[1:]))


def test_the_shipped_one_closes():
    check_linkage(load_robot("parallelogram"))


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
