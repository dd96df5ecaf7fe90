"""From equations of motion to values: the estimators that identification, replicas and diagnosis take alike.

An estimator is given equations, not logs, so that a replica is estimated as its log was. Ways to parameters
that simulate (`refinement.identifications`) start from one of these.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from pyident.conditioning.weak_form import REACH
from pyident.estimation.least_squares import Solution, solve, solve_weighted
from pyident.estimation.newey_west import LongRun
from pyident.estimation.total_least_squares import total_least_squares
from pyident.regression.equations import Problem
from pyident.regression.reduced import Reduced
from pyident.regression.regressor import predicted

_ROBUST_ROUNDS = 5


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


def ordinary(problem: Problem, like: Solution | None = None) -> Estimate:
    """Least squares, every equation alike."""
    reduced = problem.reduced()
    return Estimate(problem, reduced, solve(reduced))


def weighted(problem: Problem, like: Solution | None = None) -> Estimate:
    """Least squares, each coordinate's equations weighted by what they leave."""
    reduced = problem.reduced()
    return Estimate(problem, reduced, _solved(reduced, like))


def reweighted(problem: Problem, like: Solution | None = None) -> Estimate:
    """Weighted least squares in which single equations that stick out count less (Huber)."""
    found = weighted(problem, like)
    for _ in range(_ROBUST_ROUNDS):
        weights = [_huber(r) for r in problem.residuals(found.solution.p)]
        reduced = problem.reduced(weights)
        found = Estimate(problem, reduced, _solved(reduced, like), weights)
    return found


def total(problem: Problem, like: Solution | None = None) -> Estimate:
    """Total least squares; its values have no covariance."""
    found = weighted(problem, like)
    return replace(found, solution=total_least_squares(found.reduced, found.solution))


def _solved(reduced: Reduced, like: Solution | None) -> Solution:
    return solve_weighted(reduced) if like is None else solve(reduced, like.weights)


def _huber(residual: np.ndarray) -> np.ndarray:
    """Square roots of Huber's weights, per coordinate against its median deviation."""
    from statsmodels.robust.norms import HuberT  # here: much memory that only robust estimates need
    from statsmodels.robust.scale import mad

    scale = np.maximum(mad(residual, axis=0), 1e-300)
    return np.sqrt(HuberT().weights(residual / scale))
