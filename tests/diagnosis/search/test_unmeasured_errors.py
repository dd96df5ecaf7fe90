"""An error of the robot file that hardly exceeds the floor must be in held-out logs at its size."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from one_joint import one_joint
from two_link_logs import two_link

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.search.held_out import Unseen
from pyident.diagnosis.search.wrong_description import _believable, _exceeds, _no_chance
from pyident.rules.rules import RULES

RIGID, IN_A_LOOP = replace(one_joint(), controller=None), one_joint()
VIEW: Any = SimpleNamespace(rules=RULES.search, robot=RIGID)


@pytest.mark.parametrize(
    ("unseen", "no_chance"),
    [
        (Unseen(0.19, 0.01, 0.02, 1.0), True),
        (Unseen(0.19, 0.01, 0.02, 3.8), False),  # 2.4 times its size: it stands in for something else
        (Unseen(0.19, 0.05, 0.02, 1.0), False),  # perhaps by chance
        (None, False),
    ],
)
def test_an_imitator_of_little_has_another_size_on_other_logs(unseen, no_chance):
    entry = SimpleNamespace(unseen=unseen)
    assert _no_chance(VIEW, cast(Any, entry)) == no_chance


@pytest.mark.parametrize(
    ("error", "size", "believed"),
    [
        ("gear_ratio", 0.06, True),
        ("gear_ratio", 0.49, False),
        ("torque_gain", -0.38, False),
        ("axis[z]", 0.49, True),
    ],
)
def test_a_factor_that_no_file_is_wrong_by_is_not_told(error, size, believed):
    found = SimpleNamespace(
        candidate=Candidate(error, 1), gain=SimpleNamespace(coefficients=np.array([size]))
    )
    view: Any = SimpleNamespace(robot=two_link())
    assert _believable(view, cast(Any, SimpleNamespace(tie=[found]))) == believed


@pytest.mark.parametrize(
    ("robot", "far", "exceeds"), [(RIGID, False, True), (IN_A_LOOP, False, False), (IN_A_LOOP, True, True)]
)
def test_an_error_near_the_floor_is_told_only_along_a_motion_without_noise(robot, far, exceeds):
    """In a known loop the noise of the motion is in residual and column, and looks like a gain below one."""
    view: Any = SimpleNamespace(
        rules=RULES.search, robot=robot, over_floor=np.array([1.4]), stands_out_in=lambda _: far
    )
    entry: Any = SimpleNamespace(region=SimpleNamespace(rows=(0,)), unseen=None)
    assert _exceeds(view, entry) == exceeds
    told = SimpleNamespace(unseen=Unseen(0.19, 0.01, 0.02, 1.0))
    assert _no_chance(view, cast(Any, told)) == (robot is RIGID)
