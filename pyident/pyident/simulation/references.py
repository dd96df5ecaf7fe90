"""Experiments by name or from a file of references."""

from flexmodels import experiment as plans
from flexmodels.coordinate import feedforward_of, reference_of
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.logs.log import LogError, read_log


class ExperimentError(ValueError):
    """An experiment that cannot be run; the message says what is missing."""


def load_experiment(robot: Robot, name: str) -> Experiment:
    """`identification`, `line`, or a log file with joint{k}.r and, optionally, joint{k}.tau_ff.

    Raises ExperimentError or RobotError.
    """
    if name in ("identification", "line"):
        return getattr(plans, name)(robot)
    return read_experiment(name, len(robot.joints))


def read_experiment(path: str, joints: int) -> Experiment:
    """References joint{k}.r and, where there are, torques joint{k}.tau_ff from a log file."""
    try:
        log = read_log(path)
    except LogError as error:
        raise ExperimentError(f"{error} (experiments by name: identification, line)") from None
    numbers = range(1, joints + 1)
    missing = [reference_of(k) for k in numbers if reference_of(k) not in log.frame]
    if missing:
        raise ExperimentError(f"{path}: column {missing[0]} is missing; it is needed as a reference")
    feedforward = log.frame.reindex(columns=[feedforward_of(k) for k in numbers]).fillna(0.0).to_numpy()
    time = log.signals(["time"])[:, 0]
    return Experiment(time - time[0], log.signals([reference_of(k) for k in numbers]), feedforward)
