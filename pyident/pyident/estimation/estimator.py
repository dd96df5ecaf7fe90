"""From equations of motion to values: the estimators that identification, replicas and diagnosis take alike.

An estimator is given equations, not logs, so that a replica is estimated as its log was. Ways to parameters
that simulate (`refinement.identifications`) start from one of these.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import wraps
from typing import Protocol

import numpy as np

from pyident.conditioning.weak_form import REACH
from pyident.estimation.least_squares import Solution, solve, solve_like
from pyident.estimation.newey_west import LongRun
from pyident.estimation.prediction_error import prediction_error
from pyident.estimation.total_least_squares import total_least_squares
from pyident.regression.equations import Problem
from pyident.regression.loads.bodies import reads_load
from pyident.regression.reduced import Reduced
from pyident.regression.regressor import predicted

_ROBUST_ROUNDS = 5
_LOAD_ROUNDS = 30
_LOADS_SETTLED = 1e-7  # of the largest term: change at which the rounds end


@dataclass(frozen=True)
class Estimate:
    """Values that equations ask for.

    problem, reduced   the equations, and what they are folded into
    solution           values and their covariance as if residuals had no memory
    weights            per log (N, n) of single equations, where they were weighted
    """

    problem: Problem
    reduced: Reduced
    solution: Solution
    weights: Sequence[np.ndarray] | None = None

    def with_long_memory(self) -> "Estimate":
        """With a covariance under residuals that are correlated in time and differ in size.

        Newey and West (1987). The equations are gone through once more.
        """
        solution, reduced = self.solution, self.reduced
        lags = max(2 * REACH, int(4 * (reduced.samples / 100) ** (2 / 9)))
        meat = LongRun(len(solution.p), lags)
        squared = solution.weights**2
        for A, y in self.problem.blocks(self.weights):
            residual = squared * (y - predicted(A, solution.p))
            meat.add(np.einsum("bcp,bc->bp", A, residual) / solution.scale)
        bread = solution.seen / solution.singular_values[: solution.rank] ** 2 @ solution.seen.T
        covariance = bread @ meat.sum @ bread / np.outer(solution.scale, solution.scale)
        return replace(self, solution=replace(solution, covariance=covariance))


class Estimator(Protocol):
    """Raises LogError.

    like   a solution whose weights of the coordinates are kept: a log's, for its replicas
    """

    def __call__(self, problem: Problem, like: Solution | None = None) -> Estimate: ...


def _under_its_own_loads(solve_once: Estimator) -> Estimator:
    """An estimator whose laws of the load read that of the values which it finds, whatever the robot has.

    A load is linear in the stiffness or the bodies, and times a coefficient it is not: rounds of linear
    estimates settle it, the first of them without any load. The estimate's problem holds the values.
    """

    @wraps(solve_once)
    def estimated(problem: Problem, like: Solution | None = None) -> Estimate:
        if not reads_load(problem.robot):
            return solve_once(problem, like)
        found = solve_once(_under(problem, np.zeros(len(problem.columns))), like)
        for _ in range(_LOAD_ROUNDS):
            before = found.solution.p
            found = solve_once(_under(problem, before), like)
            terms = found.solution.scale * found.solution.p
            if np.abs(terms - found.solution.scale * before).max() <= _LOADS_SETTLED * np.abs(terms).max():
                break
        return replace(found, problem=_under(problem, found.solution.p))

    return estimated


def _under(problem: Problem, p: np.ndarray) -> Problem:
    values = dict(zip(problem.columns, p.tolist(), strict=True))
    return replace(problem, robot=problem.robot.with_parameters(values))


@_under_its_own_loads
def ordinary(problem: Problem, like: Solution | None = None) -> Estimate:
    """Least squares, every equation alike."""
    reduced = problem.reduced()
    return Estimate(problem, reduced, solve(reduced))


@_under_its_own_loads
def weighted(problem: Problem, like: Solution | None = None) -> Estimate:
    """Least squares, each coordinate's equations weighted by what they leave."""
    reduced = problem.reduced()
    return Estimate(problem, reduced, solve_like(reduced, like))


@_under_its_own_loads
def reweighted(problem: Problem, like: Solution | None = None) -> Estimate:
    """Weighted least squares in which single equations that stick out count less (Huber)."""
    found = weighted(problem, like)
    for _ in range(_ROBUST_ROUNDS):
        weights = [_huber(r) for r in problem.residuals(found.solution.p)]
        reduced = problem.reduced(weights)
        found = Estimate(problem, reduced, solve_like(reduced, like), weights)
    return found


@_under_its_own_loads
def total(problem: Problem, like: Solution | None = None) -> Estimate:
    """Total least squares; its values have no covariance."""
    found = weighted(problem, like)
    return replace(found, solution=total_least_squares(found.reduced, found.solution))


@_under_its_own_loads
def predicting(problem: Problem, like: Solution | None = None) -> Estimate:
    """Least squares of equations whose residual has lost its memory (`prediction_error`)."""
    return Estimate(*prediction_error(problem, like))


def _huber(residual: np.ndarray) -> np.ndarray:
    """Square roots of Huber's weights, per coordinate against its median deviation."""
    from statsmodels.robust.norms import HuberT  # here: much memory that only robust estimates need
    from statsmodels.robust.scale import mad

    scale = np.maximum(mad(residual, axis=0), 1e-300)
    return np.sqrt(HuberT().weights(residual / scale))
