"""The slider element: a large displacement e1 along x' and two small ones, e2 and e3, across it."""

from dataclasses import dataclass

import numpy as np

from pyident.fem.nodes import Deformation, Nodes, Position
from pyident.fem.triads import compose, cross, rotate


@dataclass(frozen=True)
class Slider:
    """Translational nodes p and q, rotational node r at p; triad (3, 3): columns x', y', z' in base axes."""

    p: int
    r: int
    q: int
    triad: np.ndarray
    modes = 3

    def carry(self, nodes: Nodes, d: Deformation) -> None:
        """Find node q from nodes p and r: x_q = x_p + n e, then its derivatives."""
        p, r = nodes.positions[self.p], nodes.orientations[self.r]
        n = compose(r.R, self.triad)
        offset, slip = rotate(n, d.e), rotate(n, d.de)
        DF = p.DF + cross(r.DF, offset)
        for mode, column in enumerate(d.columns):
            if column is not None:
                DF[:, column] += n[:, mode]
        nodes.positions[self.q] = Position(
            x=p.x + offset,
            v=p.v + slip + cross(r.w, offset),
            a=p.a + rotate(n, d.dde) + cross(r.w, 2 * slip + cross(r.w, offset)) + cross(r.dw, offset),
            DF=DF,
        )
