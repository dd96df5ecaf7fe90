"""Least squares of y = A p, eqs. (12)-(15), without ever storing A.

Blocks of rows are folded into one triangular factor per coordinate (QR), so memory does not grow with
the log; the singular value decomposition is taken of the stacked factors. Residuals per coordinate follow
from the same factors, without a second pass over the data.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

_ROUNDING = 1e-10  # of the largest singular value: below is arithmetic, not data
_NOISE = 1.0  # relative standard deviation above which a direction says nothing


@dataclass(frozen=True)
class Reduced:
    """What a least-squares problem is made of: per coordinate the triangle of [A_c, y_c].

    triangles  (n, P + 1, P + 1);  samples per coordinate;  names of rows (n) and columns (P)
    """

    triangles: np.ndarray
    samples: int
    rows: tuple[str, ...]
    columns: tuple[str, ...]

    @property
    def A(self) -> np.ndarray:
        """(n (P + 1), P): has the same A^T A as the whole regression matrix."""
        return self.triangles[:, :, :-1].reshape(-1, len(self.columns))

    @property
    def y(self) -> np.ndarray:
        return self.triangles[:, :, -1].ravel()


@dataclass(frozen=True)
class Solution:
    """The minimum-norm solution (in scaled columns) of eq. (14) and how well the data support it.

    p, std           (P,) values and standard deviations; std is inf where only a combination is seen
    singular_values  (P,) of A with columns scaled to unit length, largest first
    rank             number of directions that the data determine
    null             (P, P - rank) scaled directions that the data do not determine
    scale            (P,) length of each column of A
    residual         (n,) rms of the residual per coordinate;  signal (n,) rms of y per coordinate
    """

    p: np.ndarray
    std: np.ndarray
    singular_values: np.ndarray
    rank: int
    null: np.ndarray
    scale: np.ndarray
    residual: np.ndarray
    signal: np.ndarray


def reduce(
    blocks: Iterable[tuple[np.ndarray, np.ndarray]], rows: tuple[str, ...], columns: tuple[str, ...]
) -> Reduced:
    """Fold blocks (A (B, n, P), y (B, n)) into triangles."""
    size = len(columns) + 1
    triangles, samples = np.zeros((len(rows), size, size)), 0
    for A, y in blocks:
        samples += len(A)
        for c in range(len(rows)):
            stacked = np.vstack([triangles[c], np.column_stack([A[:, c], y[:, c]])])
            triangles[c] = _triangle(stacked, size)
    return Reduced(triangles, samples, rows, columns)


def merge(parts: list[Reduced]) -> Reduced:
    """One problem from the logs' several."""
    size = len(parts[0].columns) + 1
    stacked = np.concatenate([part.triangles for part in parts], axis=1)
    triangles = np.array([_triangle(rows, size) for rows in stacked])
    return Reduced(triangles, sum(p.samples for p in parts), parts[0].rows, parts[0].columns)


def solve(reduced: Reduced) -> Solution:
    """Pseudo-inverse solution by SVD, eq. (15), on columns scaled to unit length.

    Rank: a direction counts when its singular value stands above the arithmetic (1e-10 of the largest) and
    the residual leaves its coefficient a standard deviation below the largest coefficient found before it.
    """
    A, y = reduced.A, reduced.y
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0] = 1.0
    U, s, Vt = np.linalg.svd(A / scale, full_matrices=False)
    coefficients = U.T @ y
    rank = _rank(s, coefficients, y, reduced)
    z = Vt[:rank].T @ (coefficients[:rank] / s[:rank])
    p = z / scale
    squares = residual_squares(reduced, p)
    equations = reduced.samples * len(reduced.rows)
    sigma = np.sqrt(squares.sum() / max(equations - rank, 1))
    null = Vt[rank:].T
    std = sigma * np.linalg.norm(Vt[:rank].T / s[:rank], axis=1) / scale
    std[np.linalg.norm(null, axis=1) > 1e-4] = np.inf
    signal = np.linalg.norm(reduced.triangles[:, :, -1], axis=1)
    n = np.sqrt(reduced.samples)
    return Solution(p, std, s, rank, null, scale, np.sqrt(squares) / n, signal / n)


def residual_squares(reduced: Reduced, p: np.ndarray) -> np.ndarray:
    """Sum of squared residuals per coordinate, (n,)."""
    return ((reduced.triangles @ np.append(-p, 1.0)) ** 2).sum(axis=1)


def _triangle(rows: np.ndarray, size: int) -> np.ndarray:
    R = np.asarray(np.linalg.qr(rows, mode="r"))
    return R if len(R) == size else np.vstack([R, np.zeros((size - len(R), size))])


def _rank(s: np.ndarray, coefficients: np.ndarray, y: np.ndarray, reduced: Reduced) -> int:
    """Number of leading directions that pass the rule of `solve`."""
    rest = np.concatenate([np.cumsum((coefficients**2)[::-1])[::-1], [0.0]]) + max(
        y @ y - coefficients @ coefficients, 0
    )
    largest = np.abs(coefficients[0] / s[0])
    rank = 0
    for i in range(len(s)):
        if s[i] <= _ROUNDING * s[0]:
            break
        sigma = np.sqrt(rest[i] / (reduced.samples * len(reduced.rows)))
        if sigma / s[i] > _NOISE * largest:
            break
        largest = max(largest, abs(coefficients[i] / s[i]))
        rank = i + 1
    return rank
