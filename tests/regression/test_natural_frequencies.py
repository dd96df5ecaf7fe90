"""Natural frequencies: against a closed form, and with the mass matrix of Pinocchio."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio_model import PinocchioRobot, random_motion
from scipy.linalg import eigh
from two_link_logs import two_link

from flexmodels.files.robot_file import load_robot
from flexmodels.link import Link
from pyident.conditioning.motion import Motion
from pyident.regression.natural_frequencies import natural_frequencies


def test_a_motor_and_a_body_on_a_spring_vibrate_as_the_textbook_says():
    """Both free about one axis: ω² = k (1/J_m + 1/J)."""
    two = two_link()
    body = Link.of_centre(5.0, np.zeros(3), np.diag([0.4, 0.3, 0.2]))
    robot = replace(two, joints=two.joints[:1], links=(body,), controller=None)
    n = len(robot.coordinates)
    zero = np.zeros((1, n))
    found = natural_frequencies(robot, Motion(zero, zero, zero, tau=np.zeros((1, 1)), time=np.zeros(1)))
    p = robot.parameters
    J = {
        1: 0.3,
        2: 0.4,
        3: 0.2,
    }  # ε1 turns about the joint's x, ε2 about its z, ε3 about its y: y, x, z of the base
    expected = np.sqrt(p["joint1.k[1]"] * (1 / p["joint1.J_m"] + 1 / J[1])) / (2 * np.pi)
    assert found["joint1.eps[1]"] == pytest.approx(expected, rel=1e-9)
    for i in (2, 3):
        expected = np.sqrt(p[f"joint1.k[{i}]"] / J[i]) / (2 * np.pi)
        assert found[f"joint1.eps[{i}]"] == pytest.approx(expected, rel=1e-9)


def test_a_hinge_before_nothing_vibrates_infinitely_fast():
    two = two_link()
    body = Link.of_centre(0.0, np.zeros(3), np.zeros((3, 3)))
    robot = replace(two, joints=two.joints[:1], links=(body,), controller=None)
    zero = np.zeros((1, len(robot.coordinates)))
    found = natural_frequencies(robot, Motion(zero, zero, zero, tau=np.zeros((1, 1)), time=np.zeros(1)))
    assert set(found.values()) == {np.inf}


def test_the_modes_of_an_arm_are_those_of_pinocchios_mass_matrix():
    robot = load_robot("four_link")
    motion = Motion(*random_motion(robot, 1))
    M = PinocchioRobot(robot).mass_matrix(motion.q[0])
    stiffness = np.zeros(len(M))
    for i, c in enumerate(robot.coordinates):
        if ".eps[" in c:
            stiffness[i] = robot.parameters[c.replace(".eps[", ".k[")]
        else:
            M[i, i] += robot.parameters[c.replace(".e", ".J_m")]
    squares, modes = eigh(np.diag(stiffness), M)
    energy = stiffness[:, None] * modes**2
    share = energy / np.maximum(energy.sum(axis=0), 1e-9) * (squares > 1.0)
    found = natural_frequencies(robot, motion)
    for i, c in enumerate(robot.coordinates):
        if ".eps[" in c:
            assert found[c] == pytest.approx(np.sqrt(squares[np.argmax(share[i])]) / (2 * np.pi), rel=1e-6)
