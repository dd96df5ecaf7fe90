"""The torques that a followed reference takes, against Pinocchio's inverse dynamics and a closed form."""

import numpy as np
import pytest
from one_joint import one_joint
from pinocchio_model import PinocchioRobot

from flexmodels.files.robot_file import load_robot
from pyident.excitation.followed import followed, torques

TIME = np.linspace(0, 2, 201)


def waves(joints: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rate = 2.0 + np.arange(joints)
    s, c = np.sin(np.outer(TIME, rate)), np.cos(np.outer(TIME, rate))
    return 0.5 * s, 0.5 * rate * c, -0.5 * rate**2 * s


def test_torques_are_those_of_inverse_dynamics():
    robot = load_robot("tx40")
    values = dict.fromkeys((f"joint{k}.J_m" for k, _ in robot.numbered), 0.3)
    values |= {f"joint{k}.coulomb": 2.0 for k, _ in robot.numbered}
    values |= {f"joint{k}.viscous": 1.5 for k, _ in robot.numbered}
    robot = robot.with_parameters(values)
    q, dq, ddq = waves(6)
    motion = followed(robot, TIME, q, dq, ddq)
    oracle = PinocchioRobot(robot)
    for i in (3, 50, 120):
        bodies = oracle.inverse_dynamics(q[i], dq[i], ddq[i])
        expected = bodies + 0.3 * ddq[i] + 2.0 * np.sign(dq[i]) + 1.5 * dq[i]
        assert torques(robot, motion)[i] == pytest.approx(expected, abs=1e-8)


def test_one_joint_takes_what_its_equation_says():
    q, dq, ddq = waves(1)
    motion = followed(one_joint(), TIME, q, dq, ddq)
    expected = 1.1 * ddq + np.sign(dq) + 2.0 * dq
    assert motion.tau == pytest.approx(expected, abs=1e-9)


def test_a_stiff_hinge_bends_under_the_load_that_it_carries():
    robot = load_robot("four_link")
    q = np.zeros((11, 4))
    q[:, 1] = 0.7
    motion = followed(robot, np.arange(11) / 10, q, 0 * q, 0 * q)
    assert motion.tau is not None
    load = robot.parameters["joint2.k[1]"] * motion.q[5, robot.coordinates.index("joint2.eps[1]")]
    assert load == pytest.approx(-motion.tau[5, 1], rel=1e-2) or load == pytest.approx(
        motion.tau[5, 1], rel=1e-2
    )
