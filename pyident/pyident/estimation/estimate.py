"""From the regression to values with an honest covariance: weighting, robustness, coloured residuals."""

from dataclasses import replace

import numpy as np

from pyident.conditioning.weak_form import REACH
from pyident.estimation.least_squares import Solution, solve_weighted
from pyident.estimation.newey_west import LongRun
from pyident.regression.equations import Problem, predicted
from pyident.regression.reduced import Reduced

_ROBUST_ROUNDS = 5


def estimate(problem: Problem, robust: bool = False) -> tuple[Reduced, Solution]:
    """Weighted least squares; with `robust` single equations that stick out count less (Huber)."""
    reduced = problem.reduced()
    solution, weights = solve_weighted(reduced), None
    for _ in range(_ROBUST_ROUNDS if robust else 0):
        weights = [_huber(r) for r in problem.residuals(solution.p)]
        reduced = problem.reduced(weights)
        solution = solve_weighted(reduced)
    return reduced, replace(solution, covariance=_coloured(problem, solution, weights, reduced.samples))


def _huber(residual: np.ndarray) -> np.ndarray:
    """Square roots of Huber's weights, per coordinate against its median deviation."""
    from statsmodels.robust.norms import HuberT  # here: much memory that only --robust needs
    from statsmodels.robust.scale import mad

    scale = np.maximum(mad(residual, axis=0), 1e-300)
    return np.sqrt(HuberT().weights(residual / scale))


def _coloured(
    problem: Problem, solution: Solution, weights: list[np.ndarray] | None, samples: int
) -> np.ndarray:
    """Covariance under residuals that are correlated in time and differ in size (Newey and West 1987)."""
    meat = LongRun(len(solution.p), lags=max(2 * REACH, int(4 * (samples / 100) ** (2 / 9))))
    squared = solution.weights**2
    for A, y in problem.blocks(weights):
        residual = squared * (y - predicted(A, solution.p))
        meat.add(np.einsum("bcp,bc->bp", A, residual) / solution.scale)
    bread = solution.seen / solution.singular_values[: solution.rank] ** 2 @ solution.seen.T
    return bread @ meat.sum @ bread / np.outer(solution.scale, solution.scale)
