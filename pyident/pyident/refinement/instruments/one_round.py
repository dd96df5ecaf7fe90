"""One round of the instrumental estimate: what logs say with a simulation as their instrument."""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from flexmodels.robot import Robot
from flexmodels.threads import gathered
from pyident.estimation.instrumental_variables import MomentEquations, Rows, moment_equations, unknown
from pyident.estimation.least_squares import Solution
from pyident.refinement.instruments.following import Followed
from pyident.refinement.instruments.noise_weights import counted_alike, counted_by_noise
from pyident.refinement.instruments.residual_spectrum import of_fit
from pyident.refinement.instruments.simulated_columns import SimulatedColumns, simulated_columns
from pyident.refinement.instruments.simulated_rows import Data, Repeated, every, rows_of
from pyident.refinement.instruments.stand_in import driven
from pyident.refinement.remove_bias import seen
from pyident.simulation.simulator import Workers

TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Round:
    """What one round finds: its solution, its equations, and the simulation that it rests on.

    gap      (P,) from the parameters asked for to those found, along what the data determine
    std      (P,) of the first round's solution, the measure of changes
    columns  that the simulation adds, where they were measured
    """

    logs: Repeated
    frames: list[pd.DataFrame]
    rows: list[Rows]
    equations: MomentEquations
    solution: Solution
    gap: np.ndarray
    std: np.ndarray
    columns: SimulatedColumns | None

    def over(self, p: np.ndarray) -> float:
        """rms of what its solution leaves, over that of parameters p (P,)."""
        weights = self.equations.weights**2
        own, other = (
            sum(float((weights * r.share * r.residual(x) ** 2).sum()) for r in self.rows)
            for x in (self.solution.p, p)
        )
        return float(np.sqrt(own / max(other, TINY)))

    def largest(self, change: np.ndarray) -> float:
        """Of changes (P,) of what the data determine the largest, in standard deviations."""
        told = ~self.solution.open
        return float(np.max(np.abs(change[told]) / np.maximum(self.std[told], TINY), initial=0.0))


def next_round(logs: Repeated, made: Followed, before: Round | None, workers: Workers | None) -> Round:
    """What the logs say with the simulation as instrument; workers: to measure its columns.

    Raises SimulationError.
    """
    put_in, frames = made.put_in, made.frames
    values = np.array(list(made.wanted.linear_parameters.values()))
    quiet = np.array([put_in[name] for name in logs.reduced.columns])
    rows = gathered(partial(_rows_of, logs.robot, quiet), list(zip(logs.data, frames, strict=True)))
    if driven(logs.robot) or not logs.robot.settings.processing.filters:
        rows, weights = counted_by_noise(logs.data, rows, values)
    else:
        weights = counted_alike(rows, values)
    columns = None if before is None else before.columns
    if columns is None and workers is not None:
        columns = simulated_columns(logs, rows, workers, put_in)
    if columns is not None:
        rows = [columns.added(number, own, quiet) for number, own in enumerate(rows)]
    equations = moment_equations(every(rows), logs.reduced, weights)
    if before is None:
        solution = equations.solve(of_fit(equations))
        std = solution.std
    else:
        solution, std = equations.solve(unknown, before.solution.rank), before.std
    gap = seen(solution, solution.p - values)
    return Round(logs, frames, rows, equations, solution, gap, std, columns)


def _rows_of(robot: Robot, p: np.ndarray, log: tuple[Data, pd.DataFrame]) -> Rows:
    return rows_of(robot, *log, p)
