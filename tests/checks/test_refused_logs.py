"""What a refusal says beside its first reason, and whose fault it names."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from flexmodels.files.robot_file import load_robot
from flexmodels.loops.linkage import Closure
from flexmodels.robot import RobotError
from pyident.checks.check_log import checked
from pyident.logs.log import Log, LogError

ROBOT = load_robot("parallelogram")
TIME = np.arange(2000) * 0.004


def moved() -> Log:
    """Swings of all coordinates under torques of some size."""
    rng = np.random.default_rng(0)
    columns = {"time": TIME}
    for i, name in enumerate((*ROBOT.coordinates, *ROBOT.torques)):
        size = 1e-3 if "eps" in name else 0.3
        columns[name] = size * np.sin((i + 2) * TIME) + 1e-6 * rng.normal(size=len(TIME))
    return Log(pd.DataFrame(columns), "arm/a.csv")


def pinned_at(*point: float):
    return replace(ROBOT, closures=(Closure((4, 5), point, (0.0, 1.0, 0.0)),))


@pytest.mark.parametrize("force", [False, True])
def test_an_error_of_the_robot_is_told_as_one(force):
    with pytest.raises(RobotError) as refused:
        checked(pinned_at(-0.1, 0.3, 0.8), [moved(), moved()], force)
    said = "the pin of a closure lies on the axis of its rod's own joint; move its point"
    assert str(refused.value) == f"robot parallelogram: {said}"


def test_positions_at_which_a_linkage_does_not_close_are_the_logs():
    with pytest.raises(
        LogError, match=r"^arm/a\.csv: the structure does not close at .* zeros of its positions"
    ):
        checked(pinned_at(0.05, 0.0, 0.6), [moved()])
