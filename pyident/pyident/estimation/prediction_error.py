"""Prediction error: the memory of the residual is part of the model, y - Φ p = e / D(z), and e is made small.

With D known, D(z) y = D(z) Φ p + e is a regression whose residual has no memory, the best linear unbiased one
for exact columns; D is fitted to what the regression leaves (Ljung 1999, section 4.2; Durbin 1960). Where
differences raise the noise of high frequencies, D counts these less. It takes no bias away that noise in the
columns makes. An equation goes with each out of use that its filter needs; what changes at reversals only, as
Coulomb friction does, gains least.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyident.estimation.least_squares import Solution, residual_squares, solve_like
from pyident.regression.equations import Block, Part, Problem, weigh
from pyident.regression.reduced import Reduced

_ORDER = 48  # the longest D: differences leave a memory of some twenty samples
_ROUNDS = 4  # of residual and filter; they settle to a per mille of a standard deviation


@dataclass(frozen=True)
class Whitened(Problem):
    """A problem whose equations went through filters: per coordinate the coefficients (m + 1,) of D."""

    filters: tuple[np.ndarray, ...] = ()

    def _blocks(self, part: Part, weights: np.ndarray | None) -> Iterator[Block]:
        reach = max(len(D) for D in self.filters) - 1
        at, before = 0, None
        for A, y in super()._blocks(part, None):
            if before is None:
                before = np.zeros((reach, *A.shape[1:])), np.zeros((reach, y.shape[1]))
            whole = np.concatenate([before[0], A]), np.concatenate([before[1], y])
            before = tuple(values[len(values) - reach :] for values in whole)
            made = self._filtered(*whole, reach)
            if weights is not None:
                weigh(*made, weights[at : at + len(y)])
                at += len(y)
            yield made

    def _filtered(self, A: np.ndarray, y: np.ndarray, reach: int) -> Block:
        """The equations from sample `reach` on; zero where one that the filter needs is not in use."""
        out, target = np.zeros_like(A[reach:]), np.zeros_like(y[reach:])
        for c, D in enumerate(self.filters):
            columns = np.flatnonzero(A[:, c].any(axis=0))
            own = np.column_stack([A[:, c, columns], y[:, c]])
            known = np.asarray(own.any(axis=1))
            made, all_known = np.zeros((len(target), own.shape[1])), np.ones(len(target), bool)
            for lag, weight in enumerate(D):
                at = slice(reach - lag, len(own) - lag)
                made += weight * own[at]
                all_known &= known[at]
            made[~all_known] = 0.0
            out[:, c, columns], target[:, c] = made[:, :-1], made[:, -1]
        return out, target


def prediction_error(problem: Problem, like: Solution | None = None) -> tuple[Whitened, Reduced, Solution]:
    """The whitened problem, the plain one's fold, and the solution; like: as of an `Estimator`.

    The solution's residual is that of the plain equations.
    """
    plain = problem.reduced()
    solution = solve_like(plain, like)
    whitened = Whitened(problem.robot, problem.parts)
    for _ in range(_ROUNDS):
        filters = noise_filters(problem.residuals(solution.p))
        whitened = replace(whitened, filters=filters)
        solution = solve_like(whitened.reduced(), like)
    residual = np.sqrt(residual_squares(plain, solution.p) / plain.samples)
    return whitened, plain, replace(solution, residual=residual)


def noise_filters(residuals: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Per coordinate D (m + 1,), D[0] = 1, which whitens residuals (N, n) of logs; BIC chooses m."""
    from statsmodels.tsa.stattools import levinson_durbin

    samples = sum(len(r) for r in residuals)
    out = []
    for c in range(residuals[0].shape[1]):
        lagged = _autocovariance([r[:, c] for r in residuals]) / samples
        if lagged[0] == 0:
            out.append(np.ones(1))
            continue
        phi = levinson_durbin(lagged, _ORDER, isacov=True)[4]
        left = [lagged[0] - phi[1 : m + 1, m] @ lagged[1 : m + 1] for m in range(_ORDER + 1)]
        cost = samples * np.log(np.maximum(left, 1e-300)) + np.log(samples) * np.arange(_ORDER + 1)
        best = int(np.argmin(cost))
        out.append(np.append(1.0, -phi[1 : best + 1, best]))
    return tuple(out)


def _autocovariance(series: Sequence[np.ndarray]) -> np.ndarray:
    """(_ORDER + 1,) sums of lagged products, of several series; equations out of use are zero there."""
    total = np.zeros(_ORDER + 1)
    for values in series:
        total += [values[lag:] @ values[: len(values) - lag] for lag in range(_ORDER + 1)]
    return total
