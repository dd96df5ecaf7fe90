"""What simulates a robot, and many of them at work: the faces by which every room knows the FMUs.

`fmu_runs.FmuRuns` is the pool that is used; with `workers.inline` it works in its caller's own process.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np
import pandas as pd

from flexmodels.coordinate import motor_of
from flexmodels.inputs import Experiment, SimulationError
from flexmodels.robot import Robot

P = ParamSpec("P")
R = TypeVar("R")

Simulate = Callable[[Experiment, Sequence[Mapping[str, float]]], Iterable[pd.DataFrame]]
_ROWS = 2**21  # of all runs of one task
_LANES = 16  # runs of one task that does some work with each, of short logs
_MEASURED = "this motion was measured and cannot be simulated"
Look = Callable[[int, pd.DataFrame], None]
SimulateRivals = Callable[[Experiment], Sequence[pd.DataFrame]]


def runs_at_once(samples: int, most: int = _LANES) -> int:
    """Of experiments of so many samples: how many one task may hold in memory, at most `most`."""
    return max(1, min(most, _ROWS // samples))


class Simulator(Protocol):
    """A robot that can be simulated, such as a loaded FMU."""

    def simulate(self, experiment: Experiment, parameters: Mapping[str, float] | None = None) -> pd.DataFrame:
        """The log of an experiment, with other values of some parameters. Raises SimulationError."""
        ...

    def simulate_batch(
        self,
        experiment: Experiment | Sequence[Experiment],
        parameters: Sequence[Mapping[str, float]] = ({},),
        noise: Mapping[str, float] | None = None,
        noise_seeds: Sequence[int | None] = (None,),
        *,
        look: Look | None = None,
    ) -> list[pd.DataFrame]:
        """A log per experiment, set of parameters and seed, or as many of one as of another.

        noise   channel -> standard deviation; that of an encoder passes through the loop
        look    called now and then with the number of a run and its rows so far; what it raises ends all runs
        Raises SimulationError.
        """
        ...


class Workers(Protocol):
    """Simulators of one robot at work, in this process, in others or on a cluster."""

    def submit(
        self, work: Callable[Concatenate[Simulator, P], R], *arguments: P.args, **named: P.kwargs
    ) -> "Future[R]":
        """Call `work(simulator, *arguments)` with one of them; `work` is a function of a module."""
        ...


class Pool(Workers, Protocol):
    """Workers that also simulate many sets of parameters."""

    def __call__(
        self, experiment: Experiment, parameters: Sequence[Mapping[str, float]]
    ) -> Iterable[pd.DataFrame]:
        """One log per set of parameters, in their order. Raises SimulationError."""
        ...


class Unsimulated:
    """Stands where replicas go along a measured motion, and nothing is simulated."""

    def simulate(self, *_: Any, **__: Any) -> pd.DataFrame:
        """Raises SimulationError."""
        raise SimulationError(_MEASURED)

    def simulate_batch(self, *_: Any, **__: Any) -> list[pd.DataFrame]:
        """Raises SimulationError."""
        raise SimulationError(_MEASURED)


OpenPool = Callable[[Robot], AbstractContextManager[Pool]]


@contextmanager
def rivals(open_pool: OpenPool, robots: Sequence[Robot]) -> Iterator[SimulateRivals]:
    """Several robots over the same experiments: one log per robot, in their order.

    What simulates raises SimulationError where a robot goes elsewhere than the references.
    """
    with ExitStack() as stack:
        pools = [stack.enter_context(open_pool(robot)) for robot in robots]

        def simulate(experiment: Experiment) -> list[pd.DataFrame]:
            jobs = [pool.submit(_simulated, experiment) for pool in pools]
            return [job.result() for job in jobs]

        yield simulate


def _simulated(simulator: Simulator, experiment: Experiment) -> pd.DataFrame:
    (frame,) = simulator.simulate_batch(experiment, look=_holding(experiment))
    return frame


def _holding(experiment: Experiment) -> Look:
    """What ends a run whose joint is farther from its reference than any reference moves."""
    reference = experiment.reference
    names = [motor_of(k) for k in range(1, reference.shape[1] + 1)]
    moved = np.ptp(reference, axis=0).max()

    def look(_: int, frame: pd.DataFrame) -> None:
        off = np.abs(frame[names].to_numpy() - reference[: len(frame)]).max(axis=0)
        if not off.max() <= moved:
            raise SimulationError(f"joint{np.argmax(off) + 1} does not follow its reference")

    return look
