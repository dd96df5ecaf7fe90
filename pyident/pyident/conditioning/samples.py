"""Samples ready for the regression, all of a log or piece by piece."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pyident.conditioning.motion import Motion

_ROUNDING = 1e-12  # of a term: what its mean leaves of a constant


@dataclass(frozen=True)
class Conditioned:
    """Samples ready for the regression.

    motion   q, dq, ddq and the torques held from and until the samples, (N, n) and (N, joints)
    target   right-hand side of eq. (9): torques over zeros, (N, n)
    use      (N, n), 1 where the equation is used and 0 where its friction is not known
    thinning factor by which filtered equations are thinned out (1: not at all)
    free     equations whose torque is known but for a constant: of these only differences from their mean
             over the samples in use are equations (Frisch and Waugh 1933, with a constant as regressor)
    """

    motion: Motion
    target: np.ndarray
    use: np.ndarray
    thinning: int
    free: tuple[int, ...] = ()

    def pieces(self) -> "Iterator[Piece]":
        """All of it: what is in memory is one piece."""
        yield Piece(self, slice(0, len(self.target)))

    def cut(self, samples: slice) -> "Conditioned":
        """Some of the samples."""
        motion: dict[str, Any] = {n: x if x is None else x[samples] for n, x in vars(self.motion).items()}
        return replace(self, motion=Motion(**motion), target=self.target[samples], use=self.use[samples])

    def used(self, row: int, values: np.ndarray) -> np.ndarray:
        """Terms (..., N) of one equation as it is used: zero where it is not, without a free constant."""
        masked = values * self.use[:, row]
        if row not in self.free:
            return masked
        mean = masked.sum(axis=-1, keepdims=True) / max(float(self.use[:, row].sum()), 1.0)
        centred = masked - mean * self.use[:, row]
        size = np.abs(masked).max(axis=-1, keepdims=True)
        constant = np.abs(centred).max(axis=-1, keepdims=True) <= _ROUNDING * size
        return np.where(constant, 0.0, centred)

    def all_used(self, values: np.ndarray) -> np.ndarray:
        """The same of every equation at once: values (N, n)."""
        out = values * self.use
        for row in self.free:
            out[:, row] = self.used(row, values[:, row])
        return out


@dataclass(frozen=True)
class Piece:
    """Conditioned samples of which `own` belong to no other piece; the others are a margin for `thin`."""

    conditioned: Conditioned
    own: slice
