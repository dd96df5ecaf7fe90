"""Least squares of a base and several candidates together, from products that are taken once per candidate.

With the basis B of what the base imitates, its residual r and the columns X of all candidates, the equations
(XᵀX − XᵀB BᵀX) x = Xᵀr consist of blocks, one per candidate or pair of candidates. A search asks for many
sets that differ in one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import Base, Columns, Limits, System


@dataclass(frozen=True)
class _Own:
    """Of one candidate's K columns: BᵀX (R, K) and Xᵀr (K,)."""

    along: np.ndarray
    against: np.ndarray


@dataclass(frozen=True, eq=False)
class JointFit:
    """Sets of candidates beside one base."""

    base: Base
    _own: dict[Candidate, _Own] = field(default_factory=dict)
    _pairs: dict[tuple[Candidate, Candidate], np.ndarray] = field(default_factory=dict)

    def of(
        self, listed: Sequence[Candidate], columns: Sequence[Columns], limits: Limits
    ) -> tuple[np.ndarray, np.ndarray]:
        """The base's parameters (P,) and the candidates' coefficients within bounds, one after the other.

        columns   of each of them
        """
        own = [self._of_one(c, X) for c, X in zip(listed, columns, strict=True)]
        each = list(zip(listed, columns, strict=True))
        G = np.block([[self._of_pair(a, b) for b in each] for a in each])
        along = np.hstack([one.along for one in own])
        against = np.concatenate([one.against for one in own])
        x = System.of(G, G - along.T @ along).solved(against, *limits).coefficients
        R = self.base.directions.shape[1]
        return self.base.p - self.base.directions @ (along[:R] @ x), x

    def _of_one(self, candidate: Candidate, columns: Columns) -> _Own:
        if candidate not in self._own:
            each = list(zip(columns, self.base.basis, self.base.residual, strict=True))
            along = sum(B[c].T @ X for rows, B, _ in each for c, X in rows.items())
            against = sum(X.T @ r[c] for rows, _, r in each for c, X in rows.items())
            self._own[candidate] = _Own(np.asarray(along), np.asarray(against))
        return self._own[candidate]

    def _of_pair(self, one: tuple[Candidate, Columns], other: tuple[Candidate, Columns]) -> np.ndarray:
        """XᵀY of two candidates and their columns."""
        (a, X), (b, Y) = one, other
        if (a, b) not in self._pairs:
            product = np.zeros((len(self._own[a].against), len(self._own[b].against)))
            for own, beside in zip(X, Y, strict=True):
                for c in own.keys() & beside.keys():
                    product += own[c].T @ beside[c]
            self._pairs[a, b], self._pairs[b, a] = product, product.T
        return self._pairs[a, b]
