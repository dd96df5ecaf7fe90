"""Ways from logs to parameters, side by side: each takes the same and gives the same, and says its name."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimate import estimate
from pyident.estimation.identify import Identified, identified, without_intervals
from pyident.estimation.least_squares import solve
from pyident.estimation.total_least_squares import total_least_squares
from pyident.logs.log import Log, LogError
from pyident.refinement.auxiliary_model import identify_by_instruments
from pyident.refinement.output_error import output_error
from pyident.regression.equations import Problem
from pyident.simulation.recorded import loop_of
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]


class Estimator(Protocol):
    """Identifies a robot from logs in memory; its own parameters are never used. Raises LogError.

    open_pool   robot -> context manager of processes that hold its FMU
    """

    def __call__(
        self,
        robot: Robot,
        logs: Sequence[Log],
        open_pool: OpenPool,
        progress: Progress | None = None,
    ) -> Identified: ...


def ordinary(
    robot: Robot, logs: Sequence[Log], open_pool: OpenPool, progress: Progress | None = None
) -> Identified:
    """Least squares, every equation alike."""
    problem = _problem(robot, logs)
    reduced = problem.reduced()
    return replace(identified(robot, reduced, solve(reduced)), estimator="least squares")


def weighted(
    robot: Robot, logs: Sequence[Log], open_pool: OpenPool, progress: Progress | None = None
) -> Identified:
    """Least squares, each coordinate's equations weighted by what they leave."""
    return identified(robot, *estimate(_problem(robot, logs)))


def reweighted(
    robot: Robot, logs: Sequence[Log], open_pool: OpenPool, progress: Progress | None = None
) -> Identified:
    """Weighted least squares in which single equations that stick out count less (Huber)."""
    found = identified(robot, *estimate(_problem(robot, logs), robust=True))
    return replace(found, estimator="iteratively reweighted least squares")


def total(
    robot: Robot, logs: Sequence[Log], open_pool: OpenPool, progress: Progress | None = None
) -> Identified:
    """Total least squares."""
    reduced, solution = estimate(_problem(robot, logs))
    found = identified(robot, reduced, total_least_squares(reduced, solution))
    return without_intervals(replace(found, estimator="total least squares"))


def refined(
    robot: Robot, logs: Sequence[Log], open_pool: OpenPool, progress: Progress | None = None
) -> Identified:
    """Output error in closed loop, from the instrumental estimate. Raises LogError without a known loop."""
    for log in logs:
        obstacle = loop_of(robot, log)
        if obstacle:
            raise LogError(f"{log.source}: {obstacle}")
    told = progress or (lambda _: None)
    start = identify_by_instruments(robot, logs, open_pool, lambda share: told(0.3 * share))
    with open_pool(robot) as simulate:
        return output_error(robot, list(logs), start, simulate, progress=lambda s: told(0.3 + 0.7 * s))[0]


ESTIMATORS: dict[str, Estimator] = {
    "ols": ordinary,
    "wls": weighted,
    "irls": reweighted,
    "tls": total,
    "iv": identify_by_instruments,
    "oe": refined,
}
DEFAULT = "iv"


def _problem(robot: Robot, logs: Sequence[Log]) -> Problem:
    return Problem(robot, tuple(condition(log, robot) for log in logs))
