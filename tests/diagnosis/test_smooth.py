"""Smooth functions of a signal: what splines can and cannot say, against functions that are known."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from analytic_joint import analytic_log, free_joint
from two_link_logs import two_link

from pyident.conditioning.motion import Motion
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.unexplained.smooth import SPLINES, Variable, curve, variables, words_of

X = np.random.default_rng(0).uniform(-2, 3, 4000)


def _variable(x=X):
    return Variable("joint1.e", "position of joint 1", "force", (x,))


def test_splines_sum_to_one_and_stay_where_the_data_end():
    B = _variable().splines(np.array([-5.0, -2.0, 0.3, 2.99, 7.0]))
    assert B.sum(axis=1) == pytest.approx(np.ones(5))
    assert (B >= 0).all()
    assert B.shape[1] == SPLINES


@pytest.mark.parametrize("f", [np.sin, lambda x: x**3 - 2 * x])
def test_a_smooth_function_is_drawn_as_it_is(f):
    variable = _variable()
    B = variable.splines(X)
    coefficients, *_ = np.linalg.lstsq(B - B.mean(axis=0), f(X) - f(X).mean(), rcond=None)
    x, y = curve(variable, coefficients)
    shape = f(x) - f(X).mean()
    assert y == pytest.approx(shape, abs=0.01 * np.ptp(shape))


def test_knots_are_denser_where_the_signal_dwells():
    x = np.concatenate([np.linspace(0, 0.1, 900), np.linspace(0.1, 1, 100)])
    knots = np.unique(_variable(x).knots)
    assert (knots < 0.1).sum() > 0.8 * len(knots)


def test_what_an_equation_is_asked():
    """Never its own torque, never an acceleration, nothing that stands still; travel is from reversals."""
    robot = free_joint()
    log = cast(Any, SimpleNamespace(part=condition(analytic_log(), robot)))
    asked = variables(robot, [log], 0)
    names = {variable.name for variable in asked}
    assert {"joint1.e", "joint1.de", "time", "travel"} <= names
    assert not names & {"joint1.tau", "joint1.dde"}
    assert {variable.form for variable in asked} == {"force", "friction"}

    (travel,) = next(v for v in asked if v.name == "travel").values
    q = log.part.motion.q[:, 0]
    speed = log.part.motion.dq[:, 0]
    last, expected = 0, []
    for i in range(len(q)):
        if i and speed[i] * speed[i - 1] < 0:
            last = i
        expected.append(abs(q[i] - q[last]))
    assert travel == pytest.approx(expected)


def test_words():
    assert words_of("joint2.de") == "speed of joint 2"
    assert words_of("joint3.eps1") == "deformation 1 of joint 3"
    assert words_of("time") == "time"


def test_a_motion_without_movement_has_nothing_to_ask():
    robot = free_joint()
    still = Motion(*np.zeros((3, 200, 1)), tau=np.zeros((200, 1)), time=np.zeros(200))
    part = SimpleNamespace(motion=still)
    assert variables(robot, [cast(Any, SimpleNamespace(part=part))], 0) == []


def test_a_joint_that_stands_still_is_no_variable():
    """Neither where it stands nor its speed, which is rounding: 1e-17 rad/s beside 1 rad/s of the other."""
    n, rng = 500, np.random.default_rng(0)
    swing, rounding = np.sin(np.arange(n) / 20), 1e-17 * rng.standard_normal(n)
    q = np.column_stack([swing, np.full(n, 0.3), *np.zeros((6, n))])
    dq = np.column_stack([np.cos(np.arange(n) / 20), rounding, *np.zeros((6, n))])
    robot = two_link()
    zero = np.zeros_like(q)
    motion = Motion(q, dq, zero, np.zeros((n, 2)), np.arange(n) / 250)
    log = cast(Any, SimpleNamespace(part=SimpleNamespace(motion=motion)))
    names = {variable.name for variable in variables(robot, [log], 0)}
    assert "joint1.de" in names
    assert not names & {"joint2.e", "joint2.de"}
