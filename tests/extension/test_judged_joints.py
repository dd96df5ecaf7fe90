"""Under a stand-in for an unknown controller a law is judged by the torques of the joints where it acts."""

from types import SimpleNamespace
from typing import Any

import pytest

from pyident.extension.add_effect import _of_joints

CHANNELS = ["joint1.tau", "joint2.tau", "joint12.tau"]


@pytest.mark.parametrize(
    ("tracks", "rows", "judged"),
    [
        (True, ["joint1.e"], ["joint1.tau"]),
        (True, ["joint1.e", "joint2.e"], ["joint1.tau", "joint2.tau"]),
        (True, ["joint3.eps[1]"], CHANNELS),  # none of them is measured
        (False, ["joint1.e"], CHANNELS),
    ],
)
def test_whose_torques_judge_a_law(tracks, rows, judged):
    trial: Any = SimpleNamespace(tracks=tracks)
    assert _of_joints(trial, rows, CHANNELS) == judged
