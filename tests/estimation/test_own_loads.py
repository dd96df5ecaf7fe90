"""Friction of the load at rigid joints in logs of Pinocchio: the load is that of the values found."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio_model import PinocchioRobot
from six_axis_logs import arm, made, plain
from two_link_logs import in_process

from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import ordinary, reweighted, weighted
from pyident.estimation.identify import identify
from pyident.refinement.identifications import DEFAULT, IDENTIFICATIONS
from pyident.regression.equations import Problem
from pyident.regression.loads.bodies import link_torques

LAW, SHARE, SQUARE = "load_dependent_friction", 0.14, 4e-4


def of_the_load(q, v, load, time):
    out = plain(q, v, load, time)
    out[:, 1:3] += SHARE * np.abs(load[:, 1:3]) * np.sign(v[:, 1:3])
    return out


@pytest.fixture(scope="module")
def log():
    return made(arm(), 0, of_the_load, duration=40.0)


def with_law(robot: Robot) -> Robot:
    return robot.with_effect(2, LAW).with_effect(3, LAW)


def coefficients(robot: Robot) -> list[float]:
    return [robot.parameters[f"joint{k}.{LAW}.coefficient"] for k in (2, 3)]


def test_the_torques_of_the_links_are_pinocchios():
    robot = arm()
    motion = condition(made(robot, 0, duration=5.0), robot).motion
    oracle = PinocchioRobot(robot)
    expected = [oracle.inverse_dynamics(*x) for x in zip(motion.q, motion.dq, motion.ddq, strict=True)]
    torques = link_torques(robot, motion)
    np.testing.assert_allclose(torques, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("estimator", [weighted, reweighted])
def test_the_coefficients_are_found(log, estimator):
    found = identify(with_law(arm()), [log], estimator).robot
    assert coefficients(found) == pytest.approx([SHARE, SHARE], rel=0.02)


def test_the_file_does_not_matter(log):
    """Neither its bodies nor its coefficients."""
    robot = with_law(arm())
    heavy = robot.with_parameters({n: 3 * v + 1 for n, v in robot.linear_parameters.items()})
    a, b = (ordinary(Problem(r, (condition(log, r),))).solution for r in (robot, heavy))
    np.testing.assert_allclose(a.p, b.p, rtol=1e-5, atol=1e-6 * np.abs(a.p).max())


@pytest.mark.parametrize("seed", [1, 2])
def test_the_first_axis_whose_rotor_only_friction_tells_lies_in_its_interval(seed):
    """Its load is an inertia's alone, and no torque says how much of it is the rotor's."""

    def friction(q, v, load, time):
        out = plain(q, v, load, time)
        out[:, 0] += SHARE * np.abs(load[:, 0]) * np.sign(v[:, 0])
        return out

    robot, name = arm().with_effect(1, LAW), f"joint1.{LAW}.coefficient"
    found = IDENTIFICATIONS[DEFAULT](robot, [made(arm(), seed, friction, duration=40.0)], in_process)
    std = found.solution.std[found.reduced.columns.index(name)]
    assert abs(found.robot.parameters[name] - SHARE) < 3 * std
    assert std < 0.25 * SHARE


def test_the_default_finds_them_too(log):
    """Along the measured motion, as no controller is known."""
    found = IDENTIFICATIONS[DEFAULT](with_law(arm()), [log], in_process).robot
    assert coefficients(found) == pytest.approx([SHARE, SHARE], rel=0.02)


def test_a_flexible_joints_load_is_of_the_stiffness_that_is_found(four_link, identification_log):
    robot = four_link.with_effect(2, LAW)
    doubled = {"joint2.k[1]": 2 * robot.parameters["joint2.k[1]"]}
    names = [f"joint2.{LAW}.coefficient", "joint2.k[1]"]
    found = [
        identify(r, [identification_log]).robot.parameters for r in (robot, robot.with_parameters(doubled))
    ]
    for name in names:
        assert found[0][name] == pytest.approx(found[1][name], rel=1e-4, abs=1e-6)


def test_replacing_nothing_keeps_the_robot():
    robot = arm()
    problem = Problem(robot, (condition(made(robot, 1, duration=5.0), robot),))
    assert weighted(replace(problem)).problem.robot is robot
