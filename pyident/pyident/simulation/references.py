"""Experiments by name or from a file of references."""

from flexmodels import experiment as plans
from flexmodels.coordinate import feedforward_of, motor_of, reference_of, switch_of
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.logs.foreign import robot_log
from pyident.logs.log import Log, LogError, read_log
from pyident.logs.mapping import Mapping


class ExperimentError(ValueError):
    """An experiment that cannot be run; the message says what is missing."""


def load_experiment(robot: Robot, name: str, mapping: Mapping | None = None) -> Experiment:
    """`identification`, `line`, or a log file with joint{k}.r and, optionally, joint{k}.tau_ff.

    mapping   of the file's columns. Raises ExperimentError, LogError or RobotError.
    """
    if name in ("identification", "line"):
        return getattr(plans, name)(robot)
    if mapping is not None:
        return experiment_of(robot_log(name, robot, mapping), len(robot.joints))
    return read_experiment(name, len(robot.joints))


def read_experiment(path: str, joints: int) -> Experiment:
    """References joint{k}.r and, where there are, torques joint{k}.tau_ff from a log file.

    Raises ExperimentError.
    """
    try:
        log = read_log(path)
    except LogError as error:
        raise ExperimentError(f"{error} (experiments by name: identification, line)") from None
    return experiment_of(log, joints)


def experiment_of(log: Log, joints: int) -> Experiment:
    """The commands that a log records: joint{k}.r; where there are joint{k}.tau_ff, .on and the first .e.

    Raises ExperimentError.
    """
    numbers = range(1, joints + 1)
    missing = [reference_of(k) for k in numbers if reference_of(k) not in log.frame]
    if missing:
        raise ExperimentError(f"{log.source}: column {missing[0]} is missing; it is needed as a reference")
    feedforward = log.frame.reindex(columns=[feedforward_of(k) for k in numbers]).fillna(0.0).to_numpy()
    on = log.frame.reindex(columns=[switch_of(k) for k in numbers]).fillna(1.0).to_numpy(float)
    positions = [motor_of(k) for k in numbers]
    start = log.signals(positions)[0] if set(positions) <= set(log.frame) else None
    time = log.signals(["time"])[:, 0]
    reference = log.signals([reference_of(k) for k in numbers])
    return Experiment(time - time[0], reference, feedforward, on, start, float(time[0]))
