"""What a simulation's samples and means do to its equations depends on how its hinges ring: further columns.

The residual of a simulation under its own parameters, s(p), is taken from a log's (indirect inference). How
much rings between the samples is the doing of the hinges' dampings, so that y - s(p) = Φ p is solved with
Φ + ds/dp as columns: a Newton step, and a covariance that knows what p does to s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from flexmodels.threads import gathered
from pyident.estimation.instrumental_variables import Rows
from pyident.refinement.instruments.simulated_rows import Repeated, simulated, simulated_equations
from pyident.refinement.instruments.stand_in import driven
from pyident.regression.regressor import predicted
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Simulator, Workers, runs_at_once

_STEP = 0.25  # of a damping: so far apart are the simulations of a difference


@dataclass(frozen=True)
class SimulatedColumns:
    """ds/dp of logs: per log and parameter's place (N, n) [N m per unit]."""

    slopes: Sequence[Mapping[int, np.ndarray]]

    def added(self, log: int, rows: Rows, p: np.ndarray) -> Rows:
        """A log's rows, of which s(p) is taken already, with the columns of ds/dp."""
        if not self.slopes[log]:
            return rows
        A, y = rows.A.copy(order="K"), rows.y.copy()
        for place, slope in self.slopes[log].items():
            A[:, :, place] += slope
            y += slope * p[place]
        return replace(rows, A=A, y=y)


def simulated_columns(
    logs: Repeated, rows: Sequence[Rows], workers: Workers, put_in: Mapping[str, float]
) -> SimulatedColumns:
    """Forward differences along every damping of a hinge; none where nothing drives the simulation.

    rows     of the logs under the simulation of `put_in`, without such columns
    put_in   every parameter of that simulation
    Raises SimulationError.
    """
    if not driven(logs.robot):  # then nothing of the simulation's equations is in the targets
        return SimulatedColumns([{} for _ in logs.data])
    names = logs.reduced.columns
    asked = [j for j, name in enumerate(names) if ".d[" in name and put_in[name] > 0]
    steps = {j: _STEP * put_in[names[j]] for j in asked}
    changed = [{**put_in, names[j]: put_in[names[j]] + step} for j, step in steps.items()]
    together = max(1, runs_at_once(max(len(r.log.frame) for r in logs.again)) // len(logs.again))
    free = [d.part.free for d in logs.data]
    jobs = [
        workers.submit(_residuals, logs.robot, logs.again, free, changed[at : at + together])
        for at in range(0, len(changed), together)
    ]
    residuals = [one for job in jobs for one in job.result()]
    before = [d.y - r.y for d, r in zip(logs.data, rows, strict=True)]
    return SimulatedColumns(
        [
            {j: (made[log] - base) / steps[j] for j, made in zip(asked, residuals, strict=True)}
            for log, base in enumerate(before)
        ]
    )


def _residuals(
    fmu: Simulator,
    robot: Robot,
    again: Sequence[Repeat],
    free: Sequence[tuple[int, ...]],
    sets: Sequence[Mapping[str, float]],
) -> list[list[np.ndarray]]:
    """Per set and log (N, n): what a simulation's samples and means leave of its own equations [N m]."""
    names = list(robot.linear_parameters)
    made = simulated(fmu, again, sets)

    def left(run: tuple[int, int]) -> np.ndarray:
        number, log = run
        p = np.array([sets[number][name] for name in names])
        equations = simulated_equations(robot, made[number][log], free[log])
        return equations.y - predicted(equations.A, p)

    logs = range(len(again))
    residuals = gathered(left, [(number, log) for number in range(len(sets)) for log in logs])
    return [residuals[at : at + len(again)] for at in range(0, len(residuals), len(again))]
