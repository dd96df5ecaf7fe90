"""The triangular factor of many rows, folded in block by block: a sequential TSQR (Demmel et al. 2012).

Householder reflections by LAPACK's tpqrt take a block against the triangle, so A and [R; block] are never
formed and R is as accurate as a QR of all rows at once. Columns that were zero so far take no part.
"""

import numpy as np
from scipy.linalg import get_lapack_funcs

_INNER = 8  # columns that LAPACK reflects at a time
_tpqrt = get_lapack_funcs("tpqrt")  # of doubles


class Triangle:
    """R of [A, y] with RᵀR = [A, y]ᵀ[A, y]; `columns` are those of A that are not zero, then y (P)."""

    def __init__(self, size: int):
        self.size = size
        self.columns = np.array([size])
        self.R = np.zeros((1, 1), order="F")

    def fold(self, A: np.ndarray, y: np.ndarray) -> None:
        """Add the rows A (B, P), y (B,)."""
        self._admit(np.flatnonzero(A.any(axis=0)))
        block = np.empty((len(self.columns), len(y)))  # transposed: LAPACK stores column by column
        np.take(A.T, self.columns[:-1], axis=0, out=block[:-1], mode="clip")
        block[-1] = y
        self._reflect(block)

    def fold_columns(self, columns: np.ndarray, values: np.ndarray) -> None:
        """Add rows that are zero in all but some columns, with y = 0: values (columns, B)."""
        self._admit(columns)
        block = np.zeros((len(self.columns), values.shape[1]))
        block[np.searchsorted(self.columns, columns)] = values
        self._reflect(block)

    def _reflect(self, block: np.ndarray) -> None:
        inner = min(_INNER, len(block))
        self.R = _tpqrt(0, inner, self.R, block.T, overwrite_a=True, overwrite_b=True)[0]  # pyright: ignore

    @property
    def full(self) -> np.ndarray:
        """(P + 1, P + 1), zero in the columns that are zero in A."""
        out = np.zeros((self.size + 1, self.size + 1))
        out[: len(self.columns), self.columns] = np.triu(self.R)
        return out

    def _admit(self, found: np.ndarray) -> None:
        """Zero columns of R for what appears first in this block; R stays a triangle."""
        if np.isin(found, self.columns, assume_unique=True).all():
            return
        columns = np.union1d(self.columns, found)
        R = np.zeros((len(columns), len(columns)), order="F")
        R[: len(self.columns), np.searchsorted(columns, self.columns)] = self.R
        self.columns, self.R = columns, R
