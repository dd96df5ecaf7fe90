"""A law is not named for a sliver of the samples in which it hardly acts; one that acts there is."""

import numpy as np
import pytest
from six_axis_logs import COULOMB, VISCOUS, arm, made, plain

from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.base.setting import set_up
from pyident.diagnosis.imitators.breadth import block_of
from pyident.regression.spectrum import equations
from pyident.rules.rules import RULES

ROUND, STRIBECK = 0.05, 0.1  # rad/s
TEETH = 150.0  # per turn


def rounded(q, v, load, time):
    """As other simulators have it: no jump at rest."""
    return COULOMB * np.tanh(v / ROUND) + VISCOUS * v


def stribeck(q, v, load, time):
    out = plain(q, v, load, time)
    out[:, 1] += 4.0 * np.sign(v[:, 1]) * np.exp(-((v[:, 1] / STRIBECK) ** 2))
    return out


def loaded(q, v, load, time):
    out = plain(q, v, load, time)
    out[:, 1] += 0.05 * np.abs(load[:, 1]) * np.sign(v[:, 1])
    return out


def toothed(q, v, load, time):
    out = plain(q, v, load, time)
    out[:, 1] += 0.3 * np.cos(TEETH * q[:, 1])
    return out


def churned(q, v, load, time):
    """Oil: the square of the speed differs from a straight line at full speed most of all."""
    out = plain(q, v, load, time)
    out[:, 1] += 1.5 * np.abs(v[:, 1]) * v[:, 1]
    return out


def samples(friction, candidate: Candidate, slow: float = 0.0, burst: bool = False) -> str:
    """What the candidate's gain rests on in two logs; the floor is what the fit leaves.

    slow   frequency below which the floor rises as that of noise behind a steep filter does [Hz]
    burst  whether the second log is short and fast
    """
    robot = arm()
    second = (4.0, 4.0) if burst else (20.0, 1.0)  # s, and the pace
    logs = [made(robot, seed, friction, *form) for seed, form in enumerate([(20.0, 1.0), second])]
    setting = set_up(robot, logs)
    raw = equations(robot, [condition(log, robot) for log in logs], [log.period for log in logs])
    level = 1 / setting.solution.weights
    rises = [1 + (slow / np.tile(np.maximum(e.band.frequencies, 0.1), 2)) ** 4 for e in raw]
    levels = [level[:, None] * rise for rise in rises]
    data = [e.over(of) for e, of in zip(raw, levels, strict=True)]
    return block_of(setting.robot, data, levels, solve_base(data), [], candidate, RULES.search)


def test_a_coupling_that_is_friction_near_rest_rests_on_it():
    """With next to no ratio it is the joint's own friction with a round sign."""
    assert "slowest samples of joint 2" in samples(
        rounded, Candidate("joint_coupling", 2, (("ratio", 0.005),))
    )


@pytest.mark.parametrize(
    ("friction", "candidate"),
    [
        (stribeck, Candidate("stribeck", 2, (("velocity", STRIBECK),))),
        (loaded, Candidate("load_dependent_friction", 2)),
    ],
)
def test_a_law_that_acts_where_it_explains_rests_on_no_sliver(friction, candidate):
    assert samples(friction, candidate) == ""


def test_a_ripple_shows_where_the_joint_is_fast_and_noise_is_little():
    """Its force is the same everywhere; over the floor it is not, and what it explains is no sliver of it."""
    ripple = Candidate("torque_ripple", 2, (("order", TEETH),))
    assert samples(toothed, ripple, slow=30.0, burst=True) == ""


def test_friction_of_the_square_of_the_speed_may_rest_on_the_fastest_samples():
    """A floor that rises at low frequencies leaves a peaky motion little else that tells it from viscous."""
    assert samples(churned, Candidate("nonlinear_viscous", 2, (("power", 2.0),)), slow=4.0, burst=True) == ""
