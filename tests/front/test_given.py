"""What callers give in Python: wrong kinds of argument, logs twice, options that exclude each other."""

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint, swing
from servo_pendulum import pendulum

import pyident as pi
from pyident.simulation.fmu_runs import simulate_robot


@pytest.fixture(scope="module")
def log() -> pi.Log:
    return pi.Log(simulate_robot(one_joint(), swing(4.0)), "swing")


@pytest.mark.parametrize("logs", [3, [None], np.zeros(4)])
def test_what_is_no_log_is_said_to_be_none(logs):
    with pytest.raises(pi.LogError, match=r"is no log; give a Log, a DataFrame, the path of a file"):
        pi.check_log(one_joint(), logs)


def test_what_is_no_robot_is_said_to_be_none(log):
    with pytest.raises(pi.RobotError, match=r"None is no robot; give a Robot"):
        pi.identify(None, log)  # pyright: ignore[reportArgumentType]


def test_a_copy_of_a_fitted_log_cannot_be_held_out(log):
    with pytest.raises(pi.LogError, match=r"the data frame is held out and holds the same as swing"):
        pi.diagnose(one_joint(), log, heldout=log.frame.copy())
    with pytest.raises(pi.LogError, match=r"holds the same"):
        pi.identify(one_joint(), log, heldout=log)


def test_two_estimators_are_refused(log):
    with pytest.raises(pi.RobotError, match=r"robust is the estimator irls, and wls was asked for"):
        pi.identify(one_joint(), log, robust=True, estimator="wls")


def test_a_log_of_more_joints_than_the_robot_has_is_doubted(log):
    frame = log.frame.assign(**{f"joint{k}.e": np.sin(k * log.frame["time"]) for k in (2, 3)})
    (found,) = [d for d in pi.check_log(one_joint(), frame) if d.kind == "joints"]
    assert found.severity == "doubtful"
    assert "has 1 joint, and the log 3" in found.sentence


def test_positions_of_a_servo_are_checked():
    time = np.arange(300) * 0.005
    frame = pd.DataFrame({"time": time, "joint1.r": np.sin(time), "joint1.e": np.zeros(300)})
    with pytest.raises(pi.LogError, match=r"joint1\.e"):
        pi.identify_servo(pendulum(), frame)


def test_a_log_shows_itself_in_a_line(log):
    assert repr(log).startswith("<Log swing: ")
    assert "\n" not in repr(log)


@pytest.mark.parametrize("name", ["SimulationError", "BuildError", "ExperimentError", "StudyError"])
def test_every_exception_that_is_promised_has_a_name(name):
    assert issubclass(getattr(pi, name), Exception)
