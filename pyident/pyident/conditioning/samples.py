"""Samples ready for the regression, all of a log or piece by piece."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyident.conditioning.motion import Motion


@dataclass(frozen=True)
class Conditioned:
    """Samples ready for the regression.

    motion   q, dq, ddq and the torques held from and until the samples, (N, n) and (N, joints)
    target   right-hand side of eq. (9): torques over zeros, (N, n)
    use      (N, n), 1 where the equation is used and 0 where its friction is not known
    thinning factor by which filtered equations are thinned out (1: not at all)
    """

    motion: Motion
    target: np.ndarray
    use: np.ndarray
    thinning: int

    def pieces(self) -> "Iterator[Piece]":
        """All of it: what is in memory is one piece."""
        yield Piece(self, slice(0, len(self.target)))

    def cut(self, samples: slice) -> "Conditioned":
        """Some of the samples."""
        motion: dict[str, Any] = {n: x if x is None else x[samples] for n, x in vars(self.motion).items()}
        return Conditioned(Motion(**motion), self.target[samples], self.use[samples], self.thinning)


@dataclass(frozen=True)
class Piece:
    """Conditioned samples of which `own` belong to no other piece; the others are a margin for `thin`."""

    conditioned: Conditioned
    own: slice
