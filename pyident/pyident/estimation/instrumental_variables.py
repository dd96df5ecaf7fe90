"""Instrumental variables for the equations of a robot: Z'W(y − Φ p) = 0 in place of Φ'W(y − Φ p) = 0.

Sensor noise in Φ biases least squares: it takes noise for motion. Instruments Z follow the motion but not the
noise, so that what noise there is in y − Φ p is uncorrelated with them (Janot, Vandanjon and Gautier 2014).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyident.estimation.least_squares import ROUNDING, Directions, Solution, solution_of
from pyident.regression.machine.svd import svd
from pyident.regression.machine.threads import each
from pyident.regression.reduced import Reduced, absent
from pyident.regression.regressor import predicted
from pyident.regression.triangle import Triangle


@dataclass(frozen=True)
class Rows:
    """One log's equations with instruments: A, Z (N, n, P), y (N, n), and how much each counts (N, n)."""

    A: np.ndarray
    Z: np.ndarray
    y: np.ndarray
    share: np.ndarray

    @cached_property
    def columns(self) -> list[np.ndarray]:
        """Per equation those of A and Z that are not zero."""
        return acting(self.A, self.Z)

    @cached_property
    def instruments(self) -> list[np.ndarray]:
        """Per equation the `columns` of Z, (columns, N)."""
        return [self.Z[:, c].T[own] for c, own in enumerate(self.columns)]

    def residual(self, p: np.ndarray) -> np.ndarray:
        """y - A p, (N, n)."""
        return self.y - predicted(self.A, p)

    def turned(self, c: int, turn: np.ndarray) -> np.ndarray:
        """(r, N) instruments of equation c in directions turn (P, r)."""
        return turn[self.columns[c]].T @ self.instruments[c]

    def sums(self, c: int, values: np.ndarray) -> np.ndarray:
        """(P,) sums of instruments of equation c times values (N,)."""
        out = np.zeros(self.A.shape[2])
        out[self.columns[c]] = self.instruments[c] @ values
        return out

    def moments(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(P,) the same of all equations' values (N, n), each as it counts; weights: (n,)."""
        counted = weights**2 * self.share * values
        return np.sum([self.sums(c, of_one) for c, of_one in enumerate(counted.T)], axis=0)


def acting(*matrices: np.ndarray) -> list[np.ndarray]:
    """Per equation the columns that are not zero in every one of the matrices (N, n, P)."""
    some = np.any([matrix.any(axis=0) for matrix in matrices], axis=0)
    return [np.flatnonzero(some[c]) for c in range(len(some))]


Logs = Callable[[], Iterable[Rows]]
Scatter = Callable[[np.ndarray, np.ndarray], np.ndarray]  # directions (P, r), p (P,) -> (r, r)


@dataclass(frozen=True)
class MomentEquations:
    """The moment equations B a = b of logs with instruments; a: coefficients of scaled directions.

    reduced    of the same logs, for the names and the residuals
    weights    (n,) of the coordinates' equations
    s, Vt      (r,), (P, P) singular values and directions of the scaled instruments
    scale      (P,) lengths of the instruments' columns
    turn       (P, r) makes of instruments orthonormal columns
    B          (r, r), near diag(s)
    """

    logs: Logs
    reduced: Reduced
    weights: np.ndarray
    s: np.ndarray
    Vt: np.ndarray
    scale: np.ndarray
    turn: np.ndarray
    B: np.ndarray

    def moments(self, targets: Sequence[np.ndarray] | None = None) -> np.ndarray:
        """(r,) sums of instrument times y; targets: per log (N, n) in place of its own y."""
        b = np.zeros(len(self.B))
        for number, rows in enumerate(self.logs()):
            y = rows.y if targets is None else targets[number]
            b += self.turn.T @ rows.moments(y, self.weights)
        return b

    def solve(self, scatter: Scatter, rank: int | None = None) -> Solution:
        """The solution and its covariance.

        scatter   covariance of the sums of instrument times residual, `spectral` or another
        rank      none: directions whose standard deviation is above the largest coefficient are left out
        """
        b, r = self.moments(), len(self.B)
        if rank is None:
            a, spread = _leading(self.B, b, r)
            meat = scatter(self.turn, self._values(a))
            while r > 1 and _deviation(spread, meat, r) > np.abs(a[: r - 1]).max():
                r -= 1
                a, spread = _leading(self.B, b, r)
        else:
            r = min(rank, r)
            a, spread = _leading(self.B, b, r)
            meat = scatter(self.turn, self._values(a))
        root = (self.Vt[:r].T / self.scale[:, None]) @ spread
        covariance = root @ meat[:r, :r] @ root.T
        directions = Directions(self.s, self.Vt, self.scale, r)
        return solution_of(self.reduced, self.weights, self._values(a), covariance, directions)

    def change(self, targets: Sequence[np.ndarray], rank: int) -> np.ndarray:
        """(P,) values that targets, per log (N, n) in place of y, ask for in the leading directions."""
        return self._values(_leading(self.B, self.moments(targets), min(rank, len(self.B)))[0])

    def _values(self, a: np.ndarray) -> np.ndarray:
        return self.Vt[: len(a)].T @ a / self.scale


def moment_equations(logs: Logs, reduced: Reduced, weights: np.ndarray) -> MomentEquations:
    """The directions that the instruments span, and the moment equations in them; weights: (n,)."""
    S = _instruments(logs, weights, len(reduced.columns))
    scale = np.linalg.norm(S, axis=0)
    nothing = absent(scale, reduced.columns)
    scale[nothing] = 1.0
    _, s, Vt = svd(S / scale)
    r = int((s > ROUNDING * s[0]).sum())
    Vt[:r, nothing] = 0.0
    turn = (Vt[:r].T / s[:r]) / scale[:, None]
    B = turn.T @ products(logs, weights) @ (Vt[:r].T / scale[:, None])
    return MomentEquations(logs, reduced, weights, s, Vt, scale, turn, B)


def _instruments(logs: Logs, weights: np.ndarray, parameters: int) -> np.ndarray:
    """(K, P) of the same sums of squares as the weighted instruments of all logs."""
    triangles = [Triangle(parameters) for _ in weights]
    for rows in logs():

        def fold(c: int, rows: Rows = rows) -> None:
            triangles[c].fold_columns(rows.columns[c], rows.instruments[c] * (weights[c] * rows.share[:, c]))

        each(fold, range(len(weights)))
    return np.concatenate([triangle.full[:-1, :-1] for triangle in triangles])


def solve_instrumental(
    logs: Logs, reduced: Reduced, weights: np.ndarray, scatter: Scatter, rank: int | None = None
) -> Solution:
    """The solution of `moment_equations` (P,); see there and `MomentEquations.solve`."""
    return moment_equations(logs, reduced, weights).solve(scatter, rank)


def _leading(B: np.ndarray, b: np.ndarray, r: int) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of the r leading directions, and what turns moments into them."""
    spread = np.linalg.inv(B[:r, :r])
    return spread @ b[:r], spread


def _deviation(spread: np.ndarray, meat: np.ndarray, r: int) -> float:
    """Standard deviation of the last of r coefficients."""
    return float(np.sqrt(max(spread[-1] @ meat[:r, :r] @ spread[-1], 0.0)))


def products(logs: Logs, weights: np.ndarray) -> np.ndarray:
    """(P, P) sums of instruments times A."""
    total = 0.0
    for rows in logs():
        products = np.zeros((rows.A.shape[2],) * 2)
        for c, own in enumerate(rows.columns):
            U = rows.instruments[c] * (weights[c] ** 2 * rows.share[:, c])
            products[np.ix_(own, own)] += U @ rows.A[:, c].T[own].T
        total = total + products
    return np.asarray(total)


def unknown(turn: np.ndarray, _: np.ndarray) -> np.ndarray:
    """In place of a covariance (P, P) that nobody will look at."""
    return np.full((turn.shape[1],) * 2, np.nan)
