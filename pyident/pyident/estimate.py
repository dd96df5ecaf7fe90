"""From the regression to values with an honest covariance: weighting, robustness, coloured residuals."""

from dataclasses import replace

import numpy as np
from statsmodels.robust.norms import HuberT
from statsmodels.robust.scale import mad
from statsmodels.stats.sandwich_covariance import S_hac_simple

from pyident.conditioning import REACH
from pyident.problem import Problem
from pyident.solve import Reduced, Solution, reduce, solve_weighted

_ROBUST_ROUNDS = 5


def estimate(problem: Problem, robust: bool = False) -> tuple[Reduced, Solution]:
    """Weighted least squares; with `robust` single equations that stick out count less (Huber)."""
    reduced = reduce(problem.blocks(), problem.rows, problem.columns)
    solution, weights = solve_weighted(reduced), None
    for _ in range(_ROBUST_ROUNDS if robust else 0):
        weights = [_huber(r) for r in problem.residuals(solution.p)]
        reduced = reduce(problem.blocks(weights), problem.rows, problem.columns)
        solution = solve_weighted(reduced)
    return reduced, replace(solution, covariance=_coloured(problem, solution, weights))


def _huber(residual: np.ndarray) -> np.ndarray:
    """Square roots of Huber's weights, per coordinate against its median deviation."""
    scale = np.maximum(mad(residual, axis=0), 1e-300)
    return np.sqrt(HuberT().weights(residual / scale))


def _coloured(problem: Problem, solution: Solution, weights: list[np.ndarray] | None) -> np.ndarray:
    """Covariance under residuals that are correlated in time and differ in size (Newey and West 1987)."""
    scores = np.concatenate(
        [
            np.einsum("bcp,bc->bp", A * solution.weights[:, None] ** 2, y - A @ solution.p)
            for A, y in problem.blocks(weights)
        ]
    )
    lags = max(2 * REACH, int(4 * (len(scores) / 100) ** (2 / 9)))
    meat = S_hac_simple(scores / solution.scale, nlags=lags)
    bread = solution.seen / solution.singular_values[: solution.rank] ** 2 @ solution.seen.T
    return bread @ meat @ bread / np.outer(solution.scale, solution.scale)
