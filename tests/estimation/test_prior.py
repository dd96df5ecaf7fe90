"""What the data leave open of a six-axis arm stays near a prior; torques by Pinocchio, prior 20 % off."""

import cvxpy as cp
import numpy as np
import pytest
from one_joint import one_joint, swing
from six_axis_logs import ROTOR, arm, made

import pyident as pi
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import RobotError
from pyident.estimation.identify import identified, identify, near, of_the_same_arm
from pyident.estimation.least_squares import solve
from pyident.estimation.physical import _distance
from pyident.logs.log import Log
from pyident.regression.reduced import reduce
from pyident.simulation.fmu_runs import simulate_robot

MASSES = [f"link{k}.m" for k in range(1, 7)]


@pytest.fixture(scope="module")
def fitted():
    robot = arm()
    return robot, identify(robot, [made(robot, 1, duration=12)])


def cad(robot):
    """Bodies up to 20 % off, each as a whole, so that every one can still exist."""
    shares = {k: 1 + 0.2 * np.sin(k) for k in range(1, 7)}
    off = {n: v * shares[int(n[4])] for n, v in robot.parameters.items() if n.startswith("link")}
    return robot.with_parameters(off, "cad")


def test_bodies_stay_within_a_factor_of_two_and_the_model_still_predicts(fitted):
    robot, found = fitted
    prior = cad(robot)
    close = near(found, prior)
    ratio = np.array([close.robot.parameters[m] / prior.parameters[m] for m in MASSES])
    assert (ratio > 0.5).all()
    assert (ratio < 2.0).all()
    free = np.array([found.robot.parameters[m] / prior.parameters[m] for m in MASSES])
    assert np.abs(np.log(free)).max() > np.log(10)  # without the prior it is the data's whim
    assert close.model_error is not None
    assert close.model_error["all"] < 1.01 * found.relative_error["all"]
    assert close.robot.parameters["joint4.J_m"] == pytest.approx(ROTOR[3], rel=0.1)


def test_what_the_data_say_nothing_of_keeps_its_prior_and_is_named(fitted):
    robot, found = fitted
    prior = cad(robot)
    close = near(found, prior)
    assert found.support["link1.m"] == "no"
    assert close.robot.parameters["link1.m"] == pytest.approx(prior.parameters["link1.m"], rel=1e-3)
    assert "link1.m" in close.notes[-1]
    np.testing.assert_array_equal(close.solution.p, found.solution.p)


def test_the_distance_is_that_of_the_log_determinant():
    """A body scaled by s: tr(s I) - log det(s I) - 4 = 4 (s - 1 - log s)."""
    body = {"m": 2.0, "ms[x]": 0.1, "ms[z]": 0.2, "J[xx]": 0.3, "J[yy]": 0.3, "J[zz]": 0.2}
    robot = arm()
    bodies = {n: body.get(n.partition(".")[2], 0.0) for n in robot.parameters if n.startswith("link")}
    robot = robot.with_parameters(bodies)
    names = list(robot.linear_parameters)
    for s in (0.3, 1.0, 2.5):
        values = [v * (s if n.startswith("link2.") else 1) for n, v in robot.linear_parameters.items()]
        found = _distance(cp.Constant(np.array(values)), names, robot).value
        assert found == pytest.approx(4 * (s - 1 - np.log(s)), abs=1e-6)


def test_a_prior_of_another_arm_is_refused():
    with pytest.raises(RobotError, match="same arm"):
        of_the_same_arm(load_robot("emps"), arm())
    assert of_the_same_arm(arm(), arm()).name == arm().name


@pytest.mark.parametrize("estimator", ["wls", "iv"])
def test_data_without_noise_leave_a_prior_its_right(estimator):
    """A quiet log of one joint: the data know friction to rounding, the prior alone the link's mass."""
    robot = one_joint()
    log = Log(simulate_robot(robot, swing(4.0)), "quiet")
    found = pi.identify(robot, log, estimator=estimator, prior=robot).robot.parameters
    assert found["link1.m"] == pytest.approx(2.0, rel=1e-2)
    assert found["joint1.viscous"] == pytest.approx(2.0, rel=1e-2)


def test_a_hinge_that_the_data_give_no_stiffness_keeps_that_of_the_prior():
    """The deformation is noise alone, so that least squares finds a stiffness near zero, of either sign."""
    robot = load_robot("four_link")
    names = list(robot.linear_parameters)
    found = identified_of(robot, {"joint1.k[1]": -150.0, "joint1.d[1]": -20.0})
    assert "joint1.k[1]" in found.at_bound
    prior = robot.with_parameters({"joint1.k[1]": 7e4, "joint1.d[1]": 30.0}, "cad")
    close = near(found, prior)
    assert close.robot.parameters["joint1.k[1]"] == 7e4
    assert close.robot.parameters["joint1.d[1]"] == 30.0
    assert "joint1.k[1] keeps the 70000 N m/rad of cad" in " ".join(close.notes)
    k2 = names.index("joint2.k[1]")
    assert close.robot.parameters["joint2.k[1]"] == pytest.approx(found.solution.p[k2], rel=1e-2)
    assert "joint2.k[1]" not in " ".join(close.notes)


def identified_of(robot, changed):
    """What equations ask for whose parameters are the robot's but for the changed ones."""
    rng = np.random.default_rng(2)
    p = np.array(list((robot.linear_parameters | changed).values()))
    n = len(robot.coordinates)
    A = rng.standard_normal((200, n, len(p))) / np.maximum(np.abs(p), 1e-3)
    y = A @ p + 0.05 * rng.standard_normal((200, n))
    reduced = reduce([(A, y)], robot.coordinates, tuple(robot.linear_parameters))
    return identified(robot, reduced, solve(reduced))
