"""The experiment that a log records: what the closed loop was fed with, from a start at rest.

One function for everything that simulates a log again. A simulation starts at rest; where the log does not, a
lead-in brings the references to its start at its own speed, and is cut off afterwards.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from flexmodels.coordinate import feedforward_of, reference_of
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.logs.log import Log
from pyident.simulation.feedforward import feedforward, misfits, recoverable
from pyident.simulation.references import experiment_of

AT_REST = 0.01  # of a reference's largest speed: slower than this at the start is rest
_LEAD = 1.0  # s


@dataclass(frozen=True)
class Recorded:
    """plan: the experiment, whose first `lead` samples come before the log."""

    plan: Experiment
    lead: int = 0

    def cut(self, frame: pd.DataFrame) -> pd.DataFrame:
        """A simulation of the plan without what comes before the log; its time starts at 0."""
        if self.lead == 0:
            return frame
        frame = frame.iloc[self.lead :].reset_index(drop=True)
        return frame.assign(time=frame["time"] - frame["time"].iloc[0])


def loop_of(robot: Robot, log: Log) -> str | None:
    """What keeps a simulation under the robot's own controller from following the log; None: nothing."""
    if robot.controller is None and robot.servo is None:
        return f"robot {robot.name} has no [controller]"
    for k, _ in robot.numbered:
        if reference_of(k) not in log.frame:
            return f"column joint{k}.r is missing, the reference that a simulation follows"
    if robot.controller is None:
        return None
    if all(feedforward_of(k) in log.frame for k, _ in robot.numbered):
        return None
    if not recoverable(robot, log):
        return (
            f"it has no tau_ff, and its {1 / log.period:g} samples a second are not those of the "
            f"controller ({robot.controller.rate:g}), so that the feed-forward cannot be recovered"
        )
    wrong = misfits(robot, log)
    return wrong[0].sentence if wrong else None


def recorded(robot: Robot, log: Log) -> Recorded:
    """The references and the feed-forward of a log that `loop_of` says nothing against."""
    if robot.servo is not None:
        return Recorded(experiment_of(log, len(robot.joints)))
    reference = log.signals([reference_of(k) for k, _ in robot.numbered])
    return with_lead(log, reference, feedforward(robot, log, start_speed(log, reference)))


def start_speed(log: Log, reference: np.ndarray) -> np.ndarray:
    """(joints,) of the references (N, joints) at the first sample; zero where that is rest."""
    speed = (reference[1] - reference[0]) / log.period
    fastest = np.abs(np.diff(reference, axis=0)).max(axis=0) / log.period
    return np.zeros_like(speed) if (np.abs(speed) <= AT_REST * fastest).all() else speed


def with_lead(log: Log, reference: np.ndarray, torque: np.ndarray) -> Recorded:
    """Inputs (N, joints) from the log's first sample on, and before it what leads there."""
    time = log.signals(["time"])[:, 0]
    time, speed = time - time[0], start_speed(log, reference)
    if not speed.any():
        return Recorded(Experiment(time, reference, torque))
    lead = round(_LEAD / log.period)
    share = np.arange(lead) / lead
    way = share**3 * (1 - share / 2) - 1 / 2  # the speed rises as 3 s² - 2 s³
    before = reference[0] + np.outer(way, speed * lead * log.period)
    plan = Experiment(
        np.arange(lead + len(time)) * log.period,
        np.concatenate([before, reference]),
        np.concatenate([np.zeros((lead, torque.shape[1])), torque]),
    )
    return Recorded(plan, lead)
