"""Steps towards parameters that cannot be simulated: halved until a simulation follows."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from one_joint import one_joint

from flexmodels.inputs import SimulationError
from pyident.refinement.instruments.fixed_point import FixedPoint
from pyident.refinement.instruments.following import Followers
from pyident.refinement.instruments.missed import NotFollowedError

NAME = "joint1.viscous"
FOUND = cast(Any, None)


def robot(viscous: float):
    return one_joint().with_parameters({NAME: viscous})


def followers(largest: float, error: type[Exception]) -> Followers:
    """What follows the logs up to a value of viscous friction, and fails beyond it with an error."""

    class Held(Followers):
        def _simulated(self, wanted, found):
            if wanted.parameters[NAME] > largest:
                raise error("beyond what a loop holds")
            return {NAME: wanted.parameters[NAME]}, []

    return Held(cast(Any, SimpleNamespace()), [], cast(Any, None), None)


@pytest.mark.parametrize("error", [SimulationError, NotFollowedError])
def test_a_step_goes_as_far_as_a_simulation_follows(error):
    made = followers(1.6, error).towards(robot(3.0), FOUND, robot(1.0))
    assert (made.share, made.wanted.parameters[NAME]) == (0.25, pytest.approx(1.5))
    assert made.put_in[NAME] == pytest.approx(1.5)


def test_a_step_that_is_followed_is_gone_whole():
    made = followers(5.0, SimulationError).towards(robot(3.0), FOUND, robot(1.0))
    assert (made.share, made.wanted.parameters[NAME]) == (1.0, 3.0)


@pytest.mark.parametrize("before", [None, 1.0])
def test_where_nothing_follows_the_error_is_told(before):
    begin = None if before is None else robot(before)
    with pytest.raises(NotFollowedError, match="beyond"):
        followers(0.5, NotFollowedError).towards(robot(3.0), FOUND, begin)


def test_corrections_count_the_step_that_was_gone():
    """With half of every step gone, a linear map's slope is learnt all the same."""
    slope, offset = np.diag([0.5, -0.7]), np.array([1.0, 2.0])
    steps, p = FixedPoint(np.eye(2), np.ones(2)), np.zeros(2)
    for _ in range(40):
        step = steps.step(slope @ p + offset - p)
        steps.went(0.5)
        p = p + 0.5 * step
    assert p == pytest.approx(np.linalg.solve(np.eye(2) - slope, offset), rel=1e-8)
