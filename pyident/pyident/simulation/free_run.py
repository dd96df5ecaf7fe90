"""Free run: a robot that nothing controls, driven by the torques that a log records.

An initial window of measured positions says where and how fast it sets out; from its last sample on nothing
of the motion is looked at again, and every error of the model adds up.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd

from flexfmu.build import export_fmu, without_controller
from flexfmu.simulate import LoadedFmu
from flexmodels.coordinate import motor_of, of_joint, start_of, torque_of
from flexmodels.inputs import Experiment
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot
from flexmodels.scratch import scratch_folder
from pyident.logs.log import Log, LogError
from pyident.simulation.replay import Progress

WINDOW = 20  # samples that tell the start of a free run
_ORDER = 2  # of the polynomial through them


class Plant(Protocol):
    """What is needed of an FMU without controller."""

    def simulate_batch(
        self, experiment: Experiment, parameters: Sequence[Mapping[str, float]] = ...
    ) -> list[pd.DataFrame]: ...


@dataclass(frozen=True)
class FreeRun:
    """plan: the torques from the window's last sample on, its time counted from the log's first sample.

    start      where and how fast the joints set out there, by the FMU's parameters
    measured   (N, joints) positions of the log, or of its part, the window among them
    """

    plan: Experiment
    start: Mapping[str, float]
    measured: np.ndarray
    window: int

    def simulated(self, plant: Plant, parameters: Sequence[Mapping[str, float]]) -> list[np.ndarray]:
        """(N - window + 1, joints) per set of parameters: positions from the window's last sample on."""
        names = [motor_of(k) for k in range(1, self.measured.shape[1] + 1)]
        frames = plant.simulate_batch(self.plan, [{**self.start, **p} for p in parameters])
        return [frame[names].to_numpy() for frame in frames]

    def missed(self, plant: Plant, parameters: Sequence[Mapping[str, float]]) -> list[np.ndarray]:
        """(N - window, joints) per set of parameters: simulated - measured behind the window."""
        after = self.measured[self.window :]
        return [positions[1:] - after for positions in self.simulated(plant, parameters)]


def free_run_of(robot: Robot, log: Log, window: int = WINDOW, part: tuple[int, int] | None = None) -> FreeRun:
    """How `robot` runs freely under a log's torques, or those of a part of it (samples from and to).

    Raises LogError where a torque or a position is missing.
    """
    numbers = [k for k, _ in robot.numbered]
    names = [motor_of(k) for k in numbers]
    for name in [*names, *map(torque_of, numbers)]:
        if name not in log.frame:
            raise LogError(
                f"{log.source}: column {name} is missing; robot {robot.name} has no [controller], so it runs "
                "freely under recorded torques, from its first positions"
            )
    first, last = part or (0, len(log))
    if not _ORDER < window < last - first:
        raise LogError(
            f"{log.source}: an initial window of {window} samples does not fit {last - first} samples; "
            f"it must have more than {_ORDER} of them and leave some to simulate"
        )
    frame = log.frame.iloc[first:last]
    began = float(log.frame["time"].iloc[0])
    time, e = frame["time"].to_numpy(float), frame[names].to_numpy(float)
    since = time[:window] - time[window - 1]
    curve = np.polynomial.polynomial.polyfit(since, e[:window], _ORDER)
    start = {start_of(k): float(x) for k, x in zip(numbers, curve[0], strict=True)}
    start |= {of_joint(k, "de_0"): float(v) for k, v in zip(numbers, curve[1], strict=True)}
    torque = frame[[torque_of(k) for k in numbers]].to_numpy(float)[window - 1 :]
    plan = Experiment(time[window - 1 :] - began, np.zeros_like(torque), torque, began=began)
    return FreeRun(plan, start, e, window)


def run_freely(robot: Robot, log: Log, window: int = WINDOW, progress: Progress | None = None) -> Log:
    """The log as `robot` makes it: positions simulated from the window on, in which they are the measured.

    Raises LogError, BuildError, SimulationError.
    """
    run = free_run_of(robot, log, window)
    with plant_of(robot) as plant:
        made = plant.simulate(run.plan, run.start, progress=progress)
    known = [name for name in made if name in log.frame]
    before = log.frame[known].iloc[: window - 1]
    after = made[known].assign(time=log.frame["time"].to_numpy()[window - 1 :])
    frame = pd.concat([before, after], ignore_index=True)
    frame.loc[window - 1, list(map(motor_of, range(1, len(robot.joints) + 1)))] = run.measured[window - 1]
    names = [motor_of(k) for k in range(1, len(robot.joints) + 1)]
    missed = np.sqrt(np.mean((frame[names].to_numpy() - run.measured)[window:] ** 2, axis=0))
    return Log(frame, f"free run of {robot.name}", _told(names, missed, window, log.source))


def _told(names: Sequence[str], missed: np.ndarray, window: int, source: str) -> tuple[str, ...]:
    return tuple(
        f"{name} runs freely behind the first {window} samples of {source} and misses {error:.4g} rms"
        for name, error in zip(names, missed, strict=True)
    )


@contextmanager
def plant_of(robot: Robot) -> Iterator[LoadedFmu]:
    """The robot's FMU without its controller, in this process. Raises BuildError."""
    with scratch_folder() as folder:
        path = export_fmu(without_controller(equations(robot)), folder / "plant.fmu", light=True)
        with LoadedFmu(path) as plant:
            yield plant
