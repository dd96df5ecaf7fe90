"""A log's equations, and the same of a simulation of it: what the instrumental estimate is made of."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.instrumental_variables import Logs, Rows, fading
from pyident.estimation.physical import lower_bounds
from pyident.logs.log import Log
from pyident.refinement.stand_in import driven
from pyident.regression.equations import Problem, predicted
from pyident.regression.reduced import Reduced
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Simulator, Workers

_SMALL_STEP = 1e-4  # s
_DAMPED = 0.5  # of the damping per stiffness that the hinges have in the middle: the least simulated


@dataclass(frozen=True)
class Data:
    """A log's equations in memory, everything in use: A (N, n, P), y (N, n), use (N, n)."""

    part: Conditioned
    A: np.ndarray
    y: np.ndarray
    use: np.ndarray


@dataclass(frozen=True)
class Repeated:
    """A robot's logs, each with its equations and with what simulates it again."""

    robot: Robot
    data: list[Data]
    again: Sequence[Repeat]
    reduced: Reduced


def in_memory(robot: Robot, part: Conditioned) -> Data:
    """All equations of a log at once."""
    problem = Problem(robot, (replace(part, use=np.ones_like(part.use)),))
    blocks = [(A.copy(), y.copy()) for A, y in problem.blocks()]
    A, y = (np.concatenate(x) for x in zip(*blocks, strict=True))
    use = part.use[:: part.thinning]
    return Data(part, A, y, use)


def simulated(fmu: Simulator, again: Repeat, parameters: dict[str, float]) -> pd.DataFrame:
    """A log's motion made by the model."""
    try:
        return again.simulated(fmu.simulate, parameters)
    except SimulationError:  # what a poor start makes of a small inertia may vibrate fast
        return again.simulated(fmu.simulate, parameters | {"solver.step": _SMALL_STEP})


def simulations(
    again: Sequence[Repeat], workers: Workers, parameters: dict[str, float]
) -> list[pd.DataFrame]:
    jobs = [workers.submit(simulated, r, parameters) for r in again]
    return [job.result() for job in jobs]


def rows_of(robot: Robot, data: Data, frame: pd.DataFrame, p: np.ndarray) -> Rows:
    """Instruments from a simulation, and the log's torques without what the simulation's equations leave."""
    made = in_memory(robot, condition(Log(frame, "simulation"), robot))
    share = faded(robot, data.use * made.use)
    left = made.y - predicted(made.A, p) if driven(robot) else 0.0
    return Rows(data.A, made.A, data.y - left, share)


def faded(robot: Robot, use: np.ndarray) -> np.ndarray:
    """(N, n) how much each equation counts."""
    return fading(use) if robot.settings.processing.decimate == 1 else use


def every(rows: list[Rows]) -> Logs:
    """The logs' equations as the solver asks for them."""
    return lambda: rows


def simulable(robot: Robot, names: tuple[str, ...], values: np.ndarray) -> np.ndarray:
    """Values under which a simulation is quiet: what noise makes of a small damping or friction may be none.

    A hinge that rings would fill the sums with what happens between the samples.
    """
    given = dict(zip(names, values.tolist(), strict=True))
    pairs = {d: d.replace(".d[", ".k[") for d in given if ".d[" in d}
    ratio = float(np.median([given[d] / given[k] for d, k in pairs.items() if given[k] > 0] or [0.0]))
    least = lower_bounds(robot) | {d: _DAMPED * ratio * given[k] for d, k in pairs.items()}
    return np.array([max(v, least.get(name, -np.inf)) for name, v in given.items()])
