"""What is measured: cases, points and CPU time."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from benchmarks.peers.closed_loop import Start, run, static_start
from benchmarks.peers.reference import EventExact

from flexmodels.coordinate import of_joint
from flexmodels.experiment import Experiment, identification
from flexmodels.mechanics.plant import Equations, equations
from flexmodels.robot import Robot

REPEATS = 3
T = TypeVar("T")


@dataclass(frozen=True)
class Case:
    """A robot, what it is told to do and where its tip should be (N, 3)."""

    name: str
    robot: Robot
    equations: Equations
    experiment: Experiment
    start: Start
    tip: np.ndarray

    @property
    def duration(self) -> float:
        return float(self.experiment.time[-1])

    def error(self, tip: np.ndarray) -> float:
        """Largest distance from the reference [um]."""
        return 1e6 * float(np.linalg.norm(tip - self.tip, axis=1).max())


@dataclass(frozen=True)
class Point:
    """One run: a tool at a setting, the tip's error [um] and simulated seconds per CPU second."""

    tool: str
    setting: str
    error: float
    speed: float


def case(name: str, robot: Robot, duration: float = 1.0) -> Case:
    """The paper's identification experiment and its reference."""
    eq, experiment = equations(robot), identification(robot, duration=duration)
    start = static_start(eq, experiment.reference[0])
    return Case(name, robot, eq, experiment, start, run(EventExact(eq), robot, experiment, start))


def without_coulomb(robot: Robot) -> Robot:
    return robot.with_parameters({of_joint(k, "coulomb"): 0.0 for k, _ in robot.numbered})


def timed(work: Callable[[], T], repeats: int = REPEATS) -> tuple[float, T]:
    """Least CPU time of several runs [s], and what the first one returned."""
    seconds, results = [], []
    for _ in range(repeats):
        begin = time.process_time()
        results.append(work())
        seconds.append(time.process_time() - begin)
    return min(seconds), results[0]
