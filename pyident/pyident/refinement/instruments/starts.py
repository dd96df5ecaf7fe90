"""Where the rounds of the instrumental estimate begin: instruments from the log, freed of most noise."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from flexmodels.threads import gathered
from pyident.conditioning.filters import without_phase
from pyident.estimation.estimator import Estimate, weighted
from pyident.estimation.identify import Identified, identified, near
from pyident.estimation.instrumental_variables import Rows, moment_equations
from pyident.estimation.least_squares import Solution
from pyident.logs.log import Log
from pyident.refinement.instruments.logged import logged
from pyident.refinement.instruments.missed import NotFollowedError, missed
from pyident.refinement.instruments.residual_spectrum import of_fit, spectral
from pyident.refinement.instruments.simulated_rows import (
    Data,
    every,
    faded,
    in_memory,
    simulable,
    simulations,
)
from pyident.regression.equations import Problem
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Workers

_LOW = (0.15, 0.04)  # of the Nyquist frequency: pass the first instruments; the better start is taken


@dataclass(frozen=True)
class Begun:
    """Logs of a robot in memory, a regression of them, and starts, of which the best is to be found.

    robot   as the regression has it, where laws read what the transmissions carry
    """

    robot: Robot
    data: list[Data]
    plain: Estimate
    starts: list[Identified]


def begun(robot: Robot, logs: Sequence[Log], prior: Robot | None = None) -> Begun:
    """The logs' equations and starts from them; with a prior its bodies and hinges come first.

    Raises LogError.
    """
    parts = [logged(robot, log) for log in logs]
    plain = weighted(Problem(robot, tuple(parts)))
    robot = plain.problem.robot
    data = gathered(lambda part: in_memory(robot, part), parts)
    lows = () if robot.settings.processing.filters else _LOW
    solutions = gathered(lambda low: _started(robot, data, plain, low), lows)
    if not solutions:
        solutions = [plain.solution if prior is None else coloured(robot, data, plain)]
    starts = [identified(robot, plain.reduced, solution) for solution in solutions]
    if prior is not None:
        starts = [near(start, prior) for start in starts]
        starts = [_with_bodies_of(prior, starts[0]), *starts]
    return Begun(robot, data, plain, starts)


def _started(robot: Robot, data: list[Data], plain: Estimate, low: float) -> Solution:
    """Instruments from the log itself, of frequencies below `low`, where there is little noise."""
    from scipy.signal import butter

    sections = np.asarray(butter(4, low, output="sos"))

    rows = []
    for d in data:
        share = faded(robot, d.use)
        Z = np.zeros_like(d.A)
        for c, columns in enumerate(d.columns):
            Z[:, c, columns] = without_phase(sections, d.A[:, c][:, columns] * share[:, c, None])
        rows.append(Rows(d.A, Z, d.y, share))
    weights = plain.solution.weights
    equations = moment_equations(every(rows), plain.reduced, weights)
    return equations.solve(of_fit(equations))


def coloured(robot: Robot, data: list[Data], plain: Estimate) -> Solution:
    """The solution of a regression with a covariance under residuals that have a memory."""
    rows = [Rows(d.A, d.A, d.y, d.use.astype(float)) for d in data]
    solution = plain.solution
    turn = solution.seen / solution.singular_values[: solution.rank] / solution.scale[:, None]
    meat = spectral(every(rows), solution.weights, fitted=turn)(turn, solution.p)
    return replace(solution, covariance=turn @ meat @ turn.T)


def _with_bodies_of(prior: Robot, start: Identified) -> Identified:
    """A start with a prior's links and hinges: a noisy deformation spoils those of a regression first."""
    own = start.robot.linear_parameters
    known = {
        n: v
        for n, v in prior.parameters.items()
        if n in own and (n.startswith("link") or ".k[" in n or ".d[" in n)
    }
    return replace(start, robot=start.robot.with_parameters(known))


def nearest(starts: list[Identified], again: Sequence[Repeat], workers: Workers) -> Identified:
    """The start whose simulation follows the logs best.

    Raises SimulationError, NotFollowedError when none can be made.
    """
    errors: list[float] = []
    failure = None
    for start in starts:
        try:
            errors.append(missed(again, simulations(again, workers, put_in(start))[1]))
        except (SimulationError, NotFollowedError) as error:
            errors.append(float("inf"))
            failure = error
    if failure is not None and not np.isfinite(errors).any():
        raise failure
    return starts[int(np.argmin(errors))]


def put_in(start: Identified) -> dict[str, float]:
    """Every parameter of a simulation of the start."""
    columns, values = start.reduced.columns, start.robot.linear_parameters.values()
    quiet = simulable(start.robot, columns, np.array(list(values)))
    return start.robot.parameters | dict(zip(columns, quiet.tolist(), strict=True))
