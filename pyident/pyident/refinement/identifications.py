"""Ways from logs to an identified robot, side by side: each takes and gives the same, and says its name."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import Estimator, ordinary, predicting, reweighted, total, weighted
from pyident.estimation.identify import Identified, disagreements, identified, near, without_intervals
from pyident.logs.log import Log, LogError
from pyident.refinement.auxiliary_model import identify_by_instruments
from pyident.refinement.instruments.simulated_rows import in_memory
from pyident.refinement.instruments.starts import coloured
from pyident.refinement.output_error import output_error
from pyident.regression.equations import Problem
from pyident.simulation.recorded import loop_of
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]
_BIASED = (
    "a regression gives no intervals: noise in position biases it by many of its standard deviations; "
    "those of the default estimator hold"
)


class Identification(Protocol):
    """Identifies a robot from logs in memory; its own parameters are never used. Raises LogError.

    open_pool   robot -> context manager of processes that hold its FMU
    prior       of the same arm: what the logs leave open of the written model stays near it
    """

    def __call__(
        self,
        robot: Robot,
        logs: Sequence[Log],
        open_pool: OpenPool,
        progress: Progress | None = None,
        prior: Robot | None = None,
    ) -> Identified: ...


@dataclass(frozen=True)
class ByEquations:
    """The values that the equations of the logs ask for; nothing is simulated, and no intervals are given."""

    estimator: Estimator
    name: str

    def __call__(
        self,
        robot: Robot,
        logs: Sequence[Log],
        open_pool: OpenPool,
        progress: Progress | None = None,
        prior: Robot | None = None,
    ) -> Identified:
        parts = tuple(condition(log, robot) for log in logs)
        estimate = self.estimator(Problem(robot, parts))
        solution = estimate.solution
        if prior is not None:
            settled = estimate.problem.robot
            solution = coloured(settled, [in_memory(settled, part) for part in parts], estimate)
        found = identified(robot, estimate.reduced, solution)
        found = found if prior is None else near(found, prior)
        return replace(without_intervals(found), estimator=self.name, notes=(_BIASED, *found.notes))


def refined(
    robot: Robot,
    logs: Sequence[Log],
    open_pool: OpenPool,
    progress: Progress | None = None,
    prior: Robot | None = None,
) -> Identified:
    """Output error in closed loop, from the instrumental estimate. Raises LogError without a known loop."""
    for log in logs:
        obstacle = loop_of(robot, log)
        if obstacle:
            raise LogError(f"{log.source}: {obstacle}")
    told = progress or (lambda _: None)
    start = identify_by_instruments(robot, logs, open_pool, lambda share: told(0.3 * share))
    with open_pool(robot) as simulate:
        found = output_error(robot, logs, start, simulate, lambda share: told(0.3 + 0.7 * share))
    if prior is None:
        return found
    close = near(found, prior)
    return replace(close, notes=(*close.notes, *disagreements(close)))


IDENTIFICATIONS: dict[str, Identification] = {
    "ols": ByEquations(ordinary, "least squares"),
    "wls": ByEquations(weighted, "weighted least squares"),
    "irls": ByEquations(reweighted, "iteratively reweighted least squares"),
    "pe": ByEquations(predicting, "prediction error with an autoregressive noise model"),
    "tls": ByEquations(total, "total least squares"),
    "iv": identify_by_instruments,
    "oe": refined,
}
DEFAULT = "iv"
