"""A log against the robot's own simulation: the experiment that it records, outputs, difference."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.logs.log import Log, LogError
from pyident.simulation.recorded import Recorded, loop_of, recorded
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Simulate

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Replay:
    """A log that can be simulated again. measured (N, channels): every coordinate and motor torque."""

    log: Log
    inputs: Recorded
    measured: np.ndarray
    channels: tuple[str, ...]

    @property
    def plan(self) -> Experiment:
        return self.inputs.plan

    @property
    def repeat(self) -> Repeat:
        """The same for who wants replicas of the log."""
        return Repeat(self.log, self.plan, self.inputs.lead)

    def run(self, simulate: Simulate, parameters: Sequence[Mapping[str, float]]) -> Iterable[pd.DataFrame]:
        """The log's motion as other parameters would have made it, a frame per set, in their order."""
        return map(self.inputs.cut, simulate(self.plan, parameters))

    def missed(self, frame: pd.DataFrame) -> np.ndarray:
        """measured − simulated, (N, channels)."""
        return self.measured - frame[list(self.channels)].to_numpy()


def replay_of(robot: Robot, log: Log) -> Replay:
    """robot: fitted to the log where it lacks a feed-forward, which is then recovered.

    Raises LogError when a simulation under the robot's own controller cannot follow the log.
    """
    obstacle = loop_of(robot, log)
    if obstacle:
        raise LogError(f"{log.source}: {obstacle}")
    channels = (*robot.coordinates, *robot.torques)
    return Replay(log, recorded(robot, log), log.signals(channels), channels)
