"""Least squares of y = A p, eqs. (12)-(15), from the triangles to which the equations are reduced.

The singular value decomposition is taken of the stacked factors. Weights per coordinate and residuals per
coordinate follow from the same factors, without a second pass over the data.
"""

from dataclasses import dataclass

import numpy as np

from pyident.logs.log import LogError
from pyident.regression.machine.svd import svd
from pyident.regression.reduced import Reduced, absent

ROUNDING = 1e-10  # of the largest singular value: below is arithmetic, not data
_ABSENT = 1e-3  # entry of a scaled null direction below which a parameter is not in it
_ROUNDS = 6  # of weighting by residuals; it settles to a per mille


@dataclass(frozen=True)
class Solution:
    """The minimum-norm solution (in scaled columns) of eq. (14) and what it stands on.

    p                (P,) values
    covariance       (P, P) in the directions that the data determine
    singular_values  (P,) of A with columns scaled to unit length, largest first
    seen, null       (P, rank), (P, P - rank) scaled directions that the data do and do not determine
    scale            (P,) length of each column of A
    weights          (n,) of the coordinates' equations
    residual         (n,) rms of the residual per coordinate;  signal (n,) rms of y per coordinate
    """

    p: np.ndarray
    covariance: np.ndarray
    singular_values: np.ndarray
    seen: np.ndarray
    null: np.ndarray
    scale: np.ndarray
    weights: np.ndarray
    residual: np.ndarray
    signal: np.ndarray

    @property
    def rank(self) -> int:
        return self.seen.shape[1]

    @property
    def open(self) -> np.ndarray:
        """(P,) whether a parameter takes part in a direction that the data do not determine."""
        return np.linalg.norm(self.null, axis=1) > _ABSENT

    @property
    def std(self) -> np.ndarray:
        """(P,) standard deviations; inf where a parameter is open."""
        return np.where(self.open, np.inf, np.sqrt(np.maximum(np.diag(self.covariance), 0)))


def solve_weighted(reduced: Reduced) -> Solution:
    """Least squares with each coordinate's equations weighted by the residual that they leave.

    Equations without a right-hand side, those of deformations and passive joints, are solved exactly by zero:
    weighted by their bare residual, a smaller stiffness would leave a smaller residual, which would weigh
    more, until nothing is left of it. What tells of their error is the residual relative to the terms that
    should cancel. It counts at the size that these terms have in the equally weighted solution, which fixes
    the weight's scale. A deformation that is mostly noise still gets too small a stiffness, as in every
    regression on noisy signals (`indirect` and `output_error` remove that), but no longer none.
    Raises LogError where no equation has a right-hand side.
    """
    solution = solve(reduced)
    free = solution.signal == 0
    if free.all():
        raise LogError(
            "all torques of these logs are zero, which no parameters at all explain as well as any; a free "
            "swing tells ratios alone: measure a torque, or let a drive move the joints"
        )
    first = reduced.terms(solution.p)
    for _ in range(_ROUNDS):
        terms = reduced.terms(solution.p)
        shrunk = np.divide(first, terms, out=np.ones_like(first), where=free & (terms > 0))
        error = solution.residual * shrunk
        solution = solve(reduced, 1 / np.maximum(error, 1e-6 * error.max()))
    return solution


def solve_like(reduced: Reduced, like: Solution | None) -> Solution:
    """Least squares under the weights of another solution; None: `solve_weighted`."""
    return solve_weighted(reduced) if like is None else solve(reduced, like.weights)


def solve(reduced: Reduced, weights: np.ndarray | None = None) -> Solution:
    """Pseudo-inverse solution by SVD, eq. (15), on columns scaled to unit length.

    weights  (n,) per coordinate; none: the plain sum of squares of eq. (14)
    Rank: a direction counts when its singular value stands above the arithmetic (1e-10 of the largest) and
    the residual leaves its coefficient a standard deviation below the largest coefficient of those before it;
    the worst directions are dropped first.
    """
    weights = np.ones(len(reduced.rows)) if weights is None else weights
    A, y = reduced.stacked(weights)
    scale = np.linalg.norm(A, axis=0)
    nothing = absent(scale, reduced.columns)
    scale[nothing] = 1.0
    U, s, Vt = svd(A / scale)
    Vt[: np.count_nonzero(s > ROUNDING * s[0]), nothing] = 0.0  # else rounding: taken for a direction later
    coefficients = U.T @ y
    equations = reduced.samples * len(reduced.rows)
    rank = _rank(s, coefficients, float(y @ y), equations)
    seen = Vt[:rank].T
    p = seen @ (coefficients[:rank] / s[:rank]) / scale
    variance = (weights**2 @ residual_squares(reduced, p)) / max(equations - rank, 1)
    spread = seen / s[:rank] / scale[:, None]
    return solution_of(reduced, weights, p, variance * spread @ spread.T, Directions(s, Vt, scale, rank))


@dataclass(frozen=True)
class Directions:
    """singular_values (P,), the rows (P, P) of their scaled directions, scale (P,), and how many count."""

    singular_values: np.ndarray
    rows: np.ndarray
    scale: np.ndarray
    rank: int


def solution_of(
    reduced: Reduced, weights: np.ndarray, p: np.ndarray, covariance: np.ndarray, directions: Directions
) -> Solution:
    """Values p (P,) with what the problem tells of them: residuals, and directions seen and not."""
    n, r = np.sqrt(reduced.samples), directions.rank
    return Solution(
        p=p,
        covariance=covariance,
        singular_values=directions.singular_values,
        seen=directions.rows[:r].T,
        null=directions.rows[r:].T,
        scale=directions.scale,
        weights=weights,
        residual=np.sqrt(residual_squares(reduced, p)) / n,
        signal=np.sqrt(reduced.signal_squares) / n,
    )


def residual_squares(reduced: Reduced, p: np.ndarray) -> np.ndarray:
    """Sum of squared residuals per coordinate, (n,)."""
    return ((reduced.triangles @ np.append(-p, 1.0)) ** 2).sum(axis=1)


def _rank(s: np.ndarray, coefficients: np.ndarray, y_squared: float, equations: int) -> int:
    """Number of leading directions that pass the rule of `solve`, the last ones dropped first."""
    rank = int((s > ROUNDING * s[0]).sum())
    rest = max(y_squared - float(coefficients[:rank] @ coefficients[:rank]), 0.0)
    sigma = np.sqrt(rest / equations)
    found = np.abs(coefficients[:rank] / s[:rank])
    while rank > 1 and sigma / s[rank - 1] > found[: rank - 1].max():
        rank -= 1
    return rank
