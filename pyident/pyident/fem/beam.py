"""The beam element between two nodes with triads; a rigid link where its six deformations are zero."""

from dataclasses import dataclass

import numpy as np

from pyident.fem.nodes import Deformation, Nodes, Position
from pyident.fem.triads import cross, rotate


@dataclass(frozen=True)
class Beam:
    """Translational nodes p and q, rotational nodes r at p and s at q; vector (3,) from p to q [m]."""

    p: int
    r: int
    q: int
    s: int
    vector: np.ndarray
    modes = 6

    def carry(self, nodes: Nodes, d: Deformation) -> None:
        """Find the nodes at q from those at p, the beam being rigid."""
        p, r = nodes.positions[self.p], nodes.orientations[self.r]
        arm = rotate(r.R, self.vector)
        nodes.positions[self.q] = Position(
            x=p.x + arm,
            v=p.v + cross(r.w, arm),
            a=p.a + cross(r.dw, arm) + cross(r.w, cross(r.w, arm)),
            DF=p.DF + cross(r.DF, arm),
        )
        nodes.orientations[self.s] = r
