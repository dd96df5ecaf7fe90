"""Robot -> FMU -> logs. Beside the command line the only place that joins the packages."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
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
from pyident.simulation.workers import workers_with

P = ParamSpec("P")
R = TypeVar("R")


def simulate_robot(
    robot: Robot, experiment: Experiment, progress: Callable[[float], None] | None = None
) -> pd.DataFrame:
    """Export the robot, simulate the FMU over the experiment and return the log's frame.

    Raises BuildError, SimulationError.
    """
    with scratch_folder() as folder:
        path = export_fmu(equations(robot), folder / "plant.fmu", light=True)
        with LoadedFmu(path) as fmu:
            return fmu.simulate(experiment, progress=progress)


def fmu_joints(path: str | Path) -> int:
    """Number of an FMU's driven joints. Raises SimulationError."""
    return FmuDescription(path).joints


class FmuRuns:
    """Many simulations of one robot with different parameters; use as a context manager.

    On all cores, or on the Dask cluster that is configured (see `workers`).
    """

    def __init__(self, robot: Robot):
        self._robot = robot

    def __enter__(self) -> "FmuRuns":
        with scratch_folder() as folder:
            path = export_fmu(equations(self._robot), folder / "plant.fmu", light=True)
            content = path.read_bytes()
        self._stack = ExitStack()
        self._workers = self._stack.enter_context(workers_with(partial(loaded_fmu, content)))
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._stack.close()

    def __call__(
        self, experiment: Experiment, parameters: Sequence[Mapping[str, float]]
    ) -> Iterator[pd.DataFrame]:
        """One frame per set of parameters, in their order. Raises SimulationError."""
        jobs = [self._workers.submit(LoadedFmu.simulate, experiment, dict(p)) for p in parameters]
        for job in jobs:
            yield job.result()

    def submit(
        self, work: Callable[Concatenate[LoadedFmu, P], R], *arguments: P.args, **named: P.kwargs
    ) -> "Future[R]":
        """Call `work(fmu, *arguments)` in one of the processes; `work` is a function of a module."""
        return self._workers.submit(work, *arguments, **named)


@contextmanager
def fmu_here(robot: Robot) -> Iterator[LoadedFmu]:
    """The robot's FMU in this very process: for short experiments, over before others have started."""
    with scratch_folder() as folder:
        path = export_fmu(equations(robot), folder / "plant.fmu", light=True)
        with LoadedFmu(path) as fmu:
            yield fmu


@contextmanager
def runs_here(
    robot: Robot,
) -> Iterator[Callable[[Experiment, Sequence[Mapping[str, float]]], Iterator[pd.DataFrame]]]:
    """`FmuRuns` in this very process."""
    with fmu_here(robot) as fmu:
        yield lambda experiment, parameters: (fmu.simulate(experiment, p) for p in parameters)


class RivalRuns:
    """Simulations of several robots over the same experiments; use as a context manager.

    On all cores, or on the Dask cluster that is configured. Raises BuildError, SimulationError.
    """

    def __init__(self, robots: Sequence[Robot]):
        self._robots = tuple(robots)

    def __enter__(self) -> "RivalRuns":
        with scratch_folder() as folder:
            paths = [
                export_fmu(equations(robot), folder / f"plant{i}.fmu", light=True)
                for i, robot in enumerate(self._robots)
            ]
            contents = tuple(path.read_bytes() for path in paths)
        self._stack = ExitStack()
        self._workers = self._stack.enter_context(workers_with(partial(_loaded_fmus, contents)))
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._stack.close()

    def __call__(self, experiment: Experiment) -> list[pd.DataFrame]:
        """One frame per robot, in their order. Raises SimulationError."""
        jobs = [self._workers.submit(_simulate_one, i, experiment) for i in range(len(self._robots))]
        return [job.result() for job in jobs]


@contextmanager
def _loaded_fmus(contents: Sequence[bytes]) -> Iterator[list[LoadedFmu]]:
    with ExitStack() as stack:
        yield [stack.enter_context(loaded_fmu(content)) for content in contents]


def _simulate_one(fmus: list[LoadedFmu], number: int, experiment: Experiment) -> pd.DataFrame:
    return fmus[number].simulate(experiment)
