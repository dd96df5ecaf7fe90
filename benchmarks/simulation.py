"""Speed at equal accuracy: our FMU, MuJoCo and Pinocchio on the same arm, motion and controller.

    python -m benchmarks.simulation -o out

One second of the paper's identification experiment with four_link: digital PID at 250 Hz, held torque, gravity,
viscous and Coulomb friction, flexible hinges; and the same without Coulomb friction, where every tool solves
the same equations. Error: the largest distance of the tip from an event-exact reference, over the samples of
the controller. Time: CPU time of one thread, best of three; loading a model is not counted.
"""

import argparse
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd

from benchmarks.closed_loop import Plant, Start, run, static_start
from benchmarks.reference import EventExact
from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu, SimulationError
from flexmodels.experiment import Experiment, identification
from flexmodels.plant import Equations, equations
from flexmodels.robot import Robot
from flexmodels.robot_file import load_robot

OURS = "flexident FMU"
GOAL = 10.0  # um
REPEATS = 3
FACTORS = (2.0, 1.6, 1.0, 0.4, 0.2)  # of the FMU's own solver step
RK4_STEPS = (1e-3, 0.8e-3, 0.5e-3, 0.2e-3, 0.1e-3)  # s
IMPLICITFAST_STEPS = (0.5e-3, 0.2e-3, 0.1e-3, 0.08e-3, 0.02e-3)  # s; at 1 ms it is unstable
PINOCCHIO_STEPS = (1e-3, 0.5e-3, 0.2e-3, 0.1e-3)  # s
TIP = ["tip.x", "tip.y", "tip.z"]


@dataclass(frozen=True)
class Case:
    """A robot, what it is told to do and where its tip should be (N, 3)."""

    name: str
    robot: Robot
    equations: Equations
    experiment: Experiment
    start: Start
    tip: np.ndarray

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
    """The identification experiment and its reference."""
    eq, experiment = equations(robot), identification(robot, duration=duration)
    start = static_start(eq, experiment.reference[0])
    return Case(name, robot, eq, experiment, start, run(EventExact(eq), robot, experiment, start))


def without_coulomb(robot: Robot) -> Robot:
    return robot.with_parameters({f"joint{k}.coulomb": 0.0 for k, _ in robot.numbered})


def cpu_seconds[T](work: Callable[[], T], repeats: int = REPEATS) -> tuple[float, T]:
    """Least CPU time of several runs, and what the last one returned."""
    best = np.inf
    for _ in range(repeats):
        begin = time.process_time()
        result = work()
        best = min(best, time.process_time() - begin)
    return best, result  # pyright: ignore[reportPossiblyUnboundVariable]
