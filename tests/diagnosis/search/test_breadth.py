"""A law is not named for a sliver of the samples in which it hardly acts; one that acts there is."""

import numpy as np
import pytest
from six_axis_logs import COULOMB, VISCOUS, arm, made, plain

from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.base.setting import set_up
from pyident.diagnosis.search.breadth import block_of
from pyident.regression.spectrum import equations
from pyident.rules.rules import RULES

ROUND, STRIBECK = 0.05, 0.1  # rad/s


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


def samples(friction, candidate: Candidate) -> str:
    """What the candidate's gain rests on in two logs; the floor is what the fit leaves."""
    robot = arm()
    logs = [made(robot, seed, friction, 20.0) for seed in range(2)]
    setting = set_up(robot, logs)
    raw = equations(robot, [condition(log, robot) for log in logs], [log.period for log in logs])
    level = 1 / setting.solution.weights
    levels = [np.repeat(level[:, None], e.y.shape[1], axis=1) for e in raw]
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
