"""Robot -> FMU -> logs. Beside the command line the only place that joins the packages."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from pathlib import Path
from threading import Lock
from types import TracebackType
from typing import Concatenate, ParamSpec, TypeVar

import pandas as pd

from flexfmu.build import export_fmu
from flexfmu.fmu_file import FmuDescription
from flexfmu.simulate import LoadedFmu, loaded_fmu
from flexmodels.experiment import Experiment
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot
from flexmodels.scratch import scratch_folder
from pyident.simulation.processes.growing_pool import growing_pool
from pyident.simulation.processes.tools import Make, Processes, inline
from pyident.simulation.processes.workers import workers_with
from pyident.simulation.simulator import runs_at_once

P = ParamSpec("P")
R = TypeVar("R")
_building = Lock()  # expressions of CasADi are no matter of several threads
_LANES = 64  # runs of one task, of short experiments
OpenProcesses = Callable[[Make[LoadedFmu]], AbstractContextManager[Processes[LoadedFmu]]]


def simulate_robot(
    robot: Robot, experiment: Experiment, progress: Callable[[float], None] | None = None
) -> pd.DataFrame:
    """Export the robot, simulate the FMU over the experiment and return the log's frame.

    Raises BuildError, SimulationError.
    """
    with fmu_here(robot) as fmu:
        return fmu.simulate(experiment, progress=progress)


def fmu_joints(path: str | Path) -> int:
    """Number of an FMU's driven joints. Raises SimulationError."""
    return FmuDescription(path).joints


class FmuRuns:
    """Many simulations of one robot with different parameters; use as a context manager.

    open_processes   gives them; if nothing is said, the Dask cluster that is configured, else this process
                     and, for long work, all cores
    """

    def __init__(self, robot: Robot, open_processes: OpenProcesses = growing_pool):
        self._robot, self._open = robot, open_processes

    def __enter__(self) -> "FmuRuns":
        with scratch_folder() as folder, _building:
            path = export_fmu(equations(self._robot), folder / "plant.fmu", light=True)
            content = path.read_bytes()
        self._stack = ExitStack()
        self._processes = self._stack.enter_context(self._open(partial(loaded_fmu, content)))
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._stack.close()

    def __call__(
        self, experiment: Experiment, parameters: Sequence[Mapping[str, float]]
    ) -> Iterator[pd.DataFrame]:
        """One frame per set of parameters, in their order. Raises SimulationError.

        Sets of the same names go side by side.
        """
        together = runs_at_once(len(experiment.time), _LANES)
        listed = [dict(p) for p in parameters]
        jobs = [
            self._processes.submit(_side_by_side, experiment, listed[first : first + together])
            for first in range(0, len(listed), together)
        ]
        for job in jobs:
            yield from job.result()

    def submit(
        self, work: Callable[Concatenate[LoadedFmu, P], R], *arguments: P.args, **named: P.kwargs
    ) -> "Future[R]":
        """Call `work(fmu, *arguments)` in one of the processes; `work` is a function of a module."""
        return self._processes.submit(work, *arguments, **named)


def runs_here(robot: Robot) -> FmuRuns:
    """Runs in this very process, side by side on its cores: for short experiments, which are over before
    other processes have started."""
    return FmuRuns(robot, inline)


def runs_in_threads(robot: Robot) -> FmuRuns:
    """Runs on the Dask cluster that is configured; else in this process, side by side on its cores.

    For work that asks for many runs at once and does little with each.
    """
    return FmuRuns(robot, partial(workers_with, on_this_machine=inline))


def _side_by_side(
    fmu: LoadedFmu, experiment: Experiment, parameters: list[dict[str, float]]
) -> list[pd.DataFrame]:
    if len(parameters) == 1 or len({frozenset(p) for p in parameters}) > 1:
        return [fmu.simulate(experiment, p) for p in parameters]
    return fmu.simulate_batch(experiment, parameters)


@contextmanager
def fmu_here(robot: Robot) -> Iterator[LoadedFmu]:
    """The robot's FMU in this very process."""
    with scratch_folder() as folder:
        path = export_fmu(equations(robot), folder / "plant.fmu", light=True)
        with LoadedFmu(path) as fmu:
            yield fmu
