"""Robot -> FMU -> logs. Beside the command line the only place that joins the packages."""

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from os import cpu_count
from pathlib import Path
from types import TracebackType

import pandas as pd

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment
from flexmodels.plant import equations
from flexmodels.robot import Robot


def simulate_robot(
    robot: Robot, experiment: Experiment, progress: Callable[[float], None] | None = None
) -> pd.DataFrame:
    """Export the robot, simulate the FMU over the experiment and return the log's frame.

    Raises BuildError, SimulationError.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = export_fmu(equations(robot), Path(folder) / "plant.fmu", derivatives=False)
        with LoadedFmu(path) as fmu:
            return fmu.simulate(experiment, progress=progress)


class FmuRuns:
    """Many simulations of one robot with different parameters, on all cores; use as a context manager."""

    def __init__(self, robot: Robot):
        self._folder = tempfile.TemporaryDirectory()
        path = export_fmu(equations(robot), Path(self._folder.name) / "plant.fmu", derivatives=False)
        self._pool = ProcessPoolExecutor(
            max_workers=cpu_count(), mp_context=get_context("spawn"), initializer=_load, initargs=(path,)
        )

    def __enter__(self) -> "FmuRuns":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._pool.shutdown(cancel_futures=True)
        self._folder.cleanup()

    def __call__(
        self, experiment: Experiment, parameters: Sequence[Mapping[str, float]]
    ) -> Iterator[pd.DataFrame]:
        """One frame per set of parameters, in their order. Raises SimulationError."""
        jobs = [self._pool.submit(_run, experiment, dict(p)) for p in parameters]
        for job in jobs:
            yield job.result()


_fmu: list[LoadedFmu] = []  # the worker process's own


def _load(path: Path) -> None:
    _fmu.append(LoadedFmu(path))


def _run(experiment: Experiment, parameters: dict[str, float]) -> pd.DataFrame:
    return _fmu[0].simulate(experiment, parameters)
