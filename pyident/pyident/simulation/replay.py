"""A log against the robot's own simulation: the experiment that it records, outputs, difference."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from flexmodels.coordinate import feedforward_of, reference_of, torque_of
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.logs.log import Log, LogError

Simulate = Callable[[Experiment, Sequence[Mapping[str, float]]], Iterable[pd.DataFrame]]
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Replay:
    """A log that can be simulated again. measured (N, channels): every coordinate and motor torque."""

    log: Log
    plan: Experiment
    measured: np.ndarray
    channels: tuple[str, ...]

    def run(self, simulate: Simulate, parameters: Sequence[Mapping[str, float]]) -> Iterable[pd.DataFrame]:
        """The log's motion as other parameters would have made it, a frame per set, in their order."""
        return simulate(self.plan, parameters)

    def missed(self, frame: pd.DataFrame) -> np.ndarray:
        """measured − simulated, (N, channels)."""
        return self.measured - frame[list(self.channels)].to_numpy()


def replay_of(robot: Robot, log: Log) -> Replay:
    """Raises LogError when the log has no reference that a simulation could follow."""
    joints = [k for k, _ in robot.numbered]
    for k in joints:
        if reference_of(k) not in log.frame:
            raise LogError(
                f"{log.source}: column joint{k}.r is missing, the reference that a simulation follows"
            )
    columns = [feedforward_of(k) for k in joints]
    feedforward = log.frame.reindex(columns=columns).fillna(0.0).to_numpy()
    time = log.signals(["time"])[:, 0]
    plan = Experiment(time - time[0], log.signals([reference_of(k) for k in joints]), feedforward)
    channels = (*robot.coordinates, *(torque_of(k) for k in joints))
    return Replay(log, plan, log.signals(channels), channels)
