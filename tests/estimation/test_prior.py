"""What the data leave open of a six-axis arm stays near a prior; torques by Pinocchio."""

from dataclasses import replace

import cvxpy as cp
import numpy as np
import pytest
from one_joint import one_joint, swing
from six_axis_logs import COULOMB, ROTOR, arm, made, plain

import pyident as pi
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import RobotError
from pyident.estimation.identify import (
    disagreements,
    identified,
    identify,
    near,
    of_the_same_arm,
    soft_hinges,
)
from pyident.estimation.least_squares import solve
from pyident.estimation.physical import _deviations, _distance
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


def test_friction_that_the_data_tell_is_not_held_by_a_placeholder(fitted):
    robot, found = fitted
    names = [f"joint{k}.{law}" for k in range(1, 7) for law in ("viscous", "coulomb")]
    close = near(found, cad(robot).with_parameters(dict.fromkeys(names, 0.003)))
    np.testing.assert_allclose(
        [close.robot.parameters[n] for n in names], [found.robot.parameters[n] for n in names], rtol=0.02
    )


def with_equal_bodies():
    body = {"m": 2.0, "ms[x]": 0.1, "ms[z]": 0.2, "J[xx]": 0.3, "J[yy]": 0.3, "J[zz]": 0.2}
    robot = arm()
    bodies = {n: body.get(n.partition(".")[2], 0.0) for n in robot.parameters if n.startswith("link")}
    return robot.with_parameters(bodies)


def distance(values, names, robot):
    found = _distance(cp.Constant(values), names, robot, names).value
    assert found is not None
    return float(found)


def test_the_distance_is_that_of_the_log_determinant():
    """A body scaled by s: tr(s I) - log det(s I) - 4 = 4 (s - 1 - log s)."""
    robot = with_equal_bodies()
    names = list(robot.linear_parameters)
    for s in (0.3, 1.0, 2.5):
        values = [v * (s if n.startswith("link2.") else 1) for n, v in robot.linear_parameters.items()]
        assert distance(np.array(values), names, robot) == pytest.approx(4 * (s - 1 - np.log(s)), abs=1e-6)


def test_what_must_be_positive_is_as_far_from_zero_as_a_body_is():
    """A motor inertia scaled by s: s - 1 - log s, half a small change's square; an offset: the square."""
    robot = with_equal_bodies().with_parameters({"joint1.J_m": 0.3, "joint1.offset": 2.0})
    names, values = list(robot.linear_parameters), np.array(list(robot.linear_parameters.values()))
    whole = distance(values, names, robot)
    for name, s, expected in (
        ("joint1.J_m", 0.1, 0.1 - 1 - np.log(0.1)),
        ("joint1.J_m", 1.01, 0.01**2 / 2),
        ("joint1.offset", -1.0, 2.0),
    ):
        changed = np.where(np.array(names) == name, s * values, values)
        assert distance(changed, names, robot) - whole == pytest.approx(expected, rel=0.02, abs=1e-7)


def test_beside_a_prior_a_deviation_is_that_of_the_covariance(fitted):
    _, found = fitted
    solution, prior = found.solution, found.robot
    turn = solution.seen * solution.scale[:, None]
    D = _deviations(found.reduced, solution, prior)
    np.testing.assert_allclose(D @ D.T, turn.T @ solution.covariance @ turn, rtol=1e-3, atol=1e-12)
    white = _deviations(found.reduced, solution, None)
    unknown = replace(solution, covariance=np.full_like(solution.covariance, np.nan))
    np.testing.assert_array_equal(_deviations(found.reduced, unknown, prior), white)
    s = solution.singular_values[: solution.rank]
    np.testing.assert_allclose(np.diag(white) * s, white[0, 0] * s[0])


@pytest.mark.parametrize("estimator", ["iv", "wls"])
def test_masses_and_friction_beside_a_prior_15_percent_off(estimator):
    robot = arm()
    off = {
        n: v * (0.85 if int(n[4]) % 2 else 1.15) for n, v in robot.parameters.items() if n.startswith("link")
    }
    prior = robot.with_parameters(off, "cad")
    close = pi.identify(robot, made(robot, 2, duration=12), estimator=estimator, prior=prior).identified
    ratio = np.array([close.robot.parameters[m] / prior.parameters[m] for m in MASSES])
    assert (ratio > 0.5).all()
    assert (ratio < 2.0).all()
    assert close.model_error is not None
    assert close.model_error["all"] < 1.01 * close.relative_error["all"]
    coulomb = [close.robot.parameters[f"joint{k}.coulomb"] for k in range(1, 7)]
    np.testing.assert_allclose(coulomb, COULOMB, rtol=0.02)
    assert "disagree" not in " ".join(close.notes)


def with_a_spring(q, v, load, time):
    """A law that no body imitates, at joint 2."""
    out = plain(q, v, load, time)
    out[:, 1] += 100 * np.sin(q[:, 1]) + 30 * q[:, 1] ** 3
    return out


def test_masses_that_predict_are_kept_where_the_priors_do_not():
    """And what the prior's would cost is said: a spring of 100 N m is missing."""
    robot = arm()
    found = identify(robot, [made(robot, 1, with_a_spring, duration=12)])
    close, prior = near(found, cad(robot)), cad(robot)
    assert close.robot.parameters["link2.m"] > 5 * prior.parameters["link2.m"]
    assert close.model_error is not None
    assert close.model_error["all"] < 5
    assert "would leave 21" in " ".join(close.notes)


def test_a_prior_of_other_masses_is_said_to_be_one(fitted):
    robot, found = fitted
    heavy = robot.with_parameters(
        {n: 8 * v for n, v in robot.parameters.items() if n.startswith("link")}, "lead"
    )
    assert "more than a factor of 2 from lead: link" in " ".join(near(found, heavy).notes)
    assert "more than a factor" not in " ".join(near(found, cad(robot)).notes)


def test_logs_that_ask_for_what_no_body_can_be_are_said_to_disagree():
    """A moment of inertia below zero."""
    robot = load_robot("four_link")
    impossible = identified_of(robot, {"link4.J[zz]": -5.0})
    (note,) = disagreements(near(impossible, robot))
    assert "disagree: link4.J[zz]" in note
    assert "they ask for -4.99" in note
    assert disagreements(near(identified_of(robot, {}), robot)) == ()


def test_a_hinge_is_soft_where_its_stiffness_is_within_its_interval_of_none():
    robot = load_robot("four_link")
    found = identified_of(robot, {})
    i = found.reduced.columns.index("joint2.k[1]")
    assert soft_hinges(found.reduced.columns, found.solution, robot) == {}
    covariance = found.solution.covariance.copy()
    covariance[i, i] = found.solution.p[i] ** 2
    wide = replace(found.solution, covariance=covariance)
    own = robot.parameters
    assert soft_hinges(found.reduced.columns, wide, robot) == {
        n: own[n] for n in ("joint2.k[1]", "joint2.d[1]")
    }


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
