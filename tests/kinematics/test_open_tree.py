"""Passive joints in an open tree: the same forces as by the pins, and by gears where there are none."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.kinematics import link_forces, transfer
from pyident.kinematics.robot_structure import of_robot
from pyident.kinematics.tree import tree_of
from pyident.regression.links import LinkColumns
from pyident.regression.regressor import generalised_forces

PINNED = load_robot("parallelogram")


def motion(robot: Robot, samples: int = 40) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    q, dq, ddq = (rng.uniform(-0.3, 0.3, (samples, len(robot.coordinates))) for _ in range(3))
    return q, dq, ddq


def filled(robot: Robot, rates: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    Phi = np.zeros((*rates[0].shape, 10 * len(robot.links)))
    LinkColumns(robot, [10 * k for k in range(len(robot.links))]).fill(Phi, rates)
    return Phi


def by_the_pins(robot: Robot, rates: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Of Newton's iteration, which knows no `follows`."""
    structure, (q, dq, ddq) = of_robot(robot), (rate.T for rate in rates)
    factors = link_forces.factors(structure, transfer.nodes(structure, q, dq, ddq), np.array(robot.gravity))
    return np.concatenate(
        [np.matmul(DF.transpose(2, 1, 0), reaction.transpose(2, 0, 1)) for DF, reaction in factors], axis=2
    )


def test_the_columns_are_those_of_the_pins():
    rates = motion(PINNED)
    expected = by_the_pins(PINNED, rates)
    assert tree_of(PINNED).agrees()
    np.testing.assert_allclose(filled(PINNED, rates), expected, atol=1e-10 * np.abs(expected).max())


def test_where_follows_is_wrong_the_pins_have_the_word():
    first, *others = PINNED.passive
    less = replace(first, follows={k: 0.9 * f for k, f in first.follows.items()})
    wrong = replace(PINNED, passive=(less, *others))
    rates = motion(PINNED)
    assert not tree_of(wrong).agrees()
    np.testing.assert_allclose(filled(wrong, rates), by_the_pins(PINNED, rates), atol=1e-12)


def test_a_hinge_that_bends_in_the_loop_is_left_to_the_pins():
    """Its bends tilt the rod, however little they are in a motion, which `follows` does not know."""
    joint = PINNED.joints[1]
    laws = {"stiffness": {f"k[{i}]": 1e5 for i in (1, 2, 3)}, "damping": {f"d[{i}]": 1.0 for i in (1, 2, 3)}}
    bent = replace(joint, bends=True, values={**joint.values, **laws})
    robot = replace(PINNED, joints=(PINNED.joints[0], bent, PINNED.joints[2]))
    assert not tree_of(robot).agrees()
    rates = motion(robot)
    rates[0][:, [i for i, name in enumerate(robot.coordinates) if "eps" in name]] *= 1e-8
    expected = by_the_pins(robot, rates)
    np.testing.assert_allclose(filled(robot, rates), expected, atol=1e-10 * np.abs(expected).max())


def test_gears_do_what_pins_do():
    """A belt in the place of the rod's pin turns the same bodies by the same angles."""
    passive = tuple(replace(joint, geared=True) for joint in PINNED.passive)
    geared = replace(PINNED, passive=passive, closures=())
    q, dq, ddq = motion(PINNED)
    p = np.array(list(PINNED.linear_parameters.values()))
    forces = [generalised_forces(robot, Motion(q, dq, ddq), p) for robot in (PINNED, geared)]
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-9 * np.abs(forces[0]).max())
    tips = [transfer.tip_positions(robot, q) for robot in (PINNED, geared)]
    assert tips[1] == pytest.approx(tips[0], abs=1e-9)
