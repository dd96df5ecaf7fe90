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


def jumping(source: str, *names: str) -> Log:
    frame = moved().frame
    return Log(frame.assign(**{name: frame[name] + (TIME > 3) for name in names}), source)


def refused(*logs: Log) -> str:
    with pytest.raises(LogError) as error:
        checked(ROBOT, logs)
    return str(error.value)


def test_logs_that_are_refused_for_the_same_reason_are_named():
    logs = [jumping(f"tests/{name}.csv", "joint1.e") for name in "abc"]
    ending = "repair the channel (the same in b.csv, c.csv); --force (force=True) uses the log as it is"
    assert refused(*logs).endswith(ending)
    assert refused(logs[0]).endswith("repair the channel; --force (force=True) uses the log as it is")
    many = [replace(log, source=f"{i}/{log.source}") for i in range(2) for log in logs]
    assert "(the same in log 2, log 3, log 4 and 2 more);" in refused(*many)


def test_other_channels_that_are_wrong_are_named_with_their_logs():
    both = jumping("tests/a.csv", "joint1.e", "joint2.e")
    assert " repair the channel (wrong, too: joint2.e); --force" in refused(both)
    other = jumping("tests/b.csv", "joint2.e")
    said = refused(both, other, jumping("tests/c.csv", "joint1.e"))
    assert "(the same in c.csv; wrong, too: joint2.e in a.csv, joint2.e in b.csv); --force" in said
