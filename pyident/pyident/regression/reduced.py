"""Equations y = A p folded into triangles, without ever storing A.

Blocks of rows go into one triangular factor per coordinate (QR), so memory does not grow with the log.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from pyident.regression.machine.threads import each
from pyident.regression.triangle import Triangle

_ROUNDING = 1e-12  # of the longest column of the same unit


@dataclass(frozen=True)
class Reduced:
    """What a least-squares problem is made of: per coordinate the triangle of [A_c, y_c].

    triangles  (n, P + 1, P + 1);  samples per coordinate;  names of rows (n) and columns (P)
    shift      (P,) y_c is what was measured, and A_c shift (`LoadTangent`)
    """

    triangles: np.ndarray
    samples: int
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    shift: np.ndarray

    @property
    def signal_squares(self) -> np.ndarray:
        """(n,) sum of the squares of what was measured."""
        measured = self.triangles[:, :, -1] - self.triangles[:, :, :-1] @ self.shift
        return np.square(measured).sum(axis=1)

    def stacked(self, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A (n (P + 1), P) and y of the weighted problem, of the same normal equations."""
        weighted = self.triangles * weights[:, None, None]
        return weighted[:, :, :-1].reshape(-1, len(self.columns)), weighted[:, :, -1].ravel()

    def terms(self, p: np.ndarray) -> np.ndarray:
        """(n,) root of the summed mean squares of the single terms A_ci p_i per coordinate."""
        squares = (self.triangles[:, :, :-1] ** 2).sum(axis=1) / self.samples
        return np.sqrt(squares @ p**2)


def reduce(
    blocks: Iterable[tuple[np.ndarray, np.ndarray]],
    rows: tuple[str, ...],
    columns: tuple[str, ...],
    shift: np.ndarray | None = None,
) -> Reduced:
    """Fold blocks (A (B, n, P), y (B, n)) into triangles; shift (P,) of y, none: y is what was measured."""
    triangles, samples = [Triangle(len(columns)) for _ in rows], 0
    for A, y in blocks:
        samples += len(A)
        each(lambda c, A=A, y=y: triangles[c].fold(A[:, c], y[:, c]), range(len(rows)))
    shift = np.zeros(len(columns)) if shift is None else shift
    return Reduced(np.stack([triangle.full for triangle in triangles]), samples, rows, columns, shift)


def absent(lengths: np.ndarray, columns: Sequence[str]) -> np.ndarray:
    """(P,) which columns of these lengths (P,) are zero, some of them but for rounding.

    What cancels in the sums of a link's forces, such as a moment about a vertical axis, leaves some 1e-16 of
    what the same parameters of other links have; scaled to one it would pass for a direction that is seen.
    """
    largest: dict[str, float] = {}
    for name, length in zip(columns, lengths.tolist(), strict=True):
        largest[unit_of(name)] = max(largest.get(unit_of(name), 0.0), length)
    return lengths <= _ROUNDING * np.array([largest[unit_of(name)] for name in columns])


def unit_of(name: str) -> str:
    """Of a link's parameter `m`, `ms` or `J`, which all links share; any other is alone with its unit."""
    return name.partition(".")[2].partition("[")[0] if name.startswith("link") else name
