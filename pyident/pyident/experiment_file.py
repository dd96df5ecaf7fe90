"""Experiments by name or from a file of references."""

import numpy as np

from flexmodels import experiment as plans
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.log import LogError, read_log


class ExperimentError(ValueError):
    """An experiment that cannot be run; the message says what is missing."""


def load_experiment(robot: Robot, name: str) -> Experiment:
    """`identification`, `line`, or a log file with joint{k}.r and, optionally, joint{k}.tau_ff.

    Raises ExperimentError or RobotError.
    """
    if name in ("identification", "line"):
        return getattr(plans, name)(robot)
    try:
        log = read_log(name)
    except LogError as error:
        raise ExperimentError(f"{error} (experiments by name: identification, line)") from None
    joints = [k for k, _ in robot.numbered]
    missing = [f"joint{k}.r" for k in joints if f"joint{k}.r" not in log.frame]
    if missing:
        raise ExperimentError(
            f"{name}: column {missing[0]} is missing; an experiment needs every joint's reference"
        )
    reference = log.signals([f"joint{k}.r" for k in joints])
    feedforward = [
        log.frame[f"joint{k}.tau_ff"].to_numpy(dtype=float)
        if f"joint{k}.tau_ff" in log.frame
        else np.zeros(len(log))
        for k in joints
    ]
    time = log.signals(["time"])[:, 0]
    return Experiment(time - time[0], reference, np.column_stack(feedforward))
