"""The slider element: a large displacement e1 along x' and two small ones, e2 and e3, across it."""

from dataclasses import dataclass

import numpy as np

from pyident.kinematics.elements.nodes import Deformation, Node, Nodes, Position, Shape, Velocity
from pyident.kinematics.elements.triads import compose, cross, rotate, turning, unrotate


@dataclass(frozen=True)
class Slider:
    """Translational nodes p and q, rotational node r at p; triad (3, 3): columns x', y', z' in base axes."""

    p: int
    r: int
    q: int
    triad: np.ndarray
    modes = 3
    turns = ()

    @property
    def inner(self) -> tuple[Node, ...]:
        return ("x", self.p), ("R", self.r)

    @property
    def outer(self) -> tuple[Node, ...]:
        return (("x", self.q),)

    def D(self, shape: Shape) -> np.ndarray:
        """Deformations (3, N): the displacement from p to q along x', y', z' [m]."""
        return unrotate(compose(shape["R", self.r], self.triad), shape["x", self.q] - shape["x", self.p])

    def DD(self, shape: Shape) -> np.ndarray:
        """(3, 9, N): rates of the deformations per unit of v_p, ω_r and v_q."""
        n = compose(shape["R", self.r], self.triad)
        offset = shape["x", self.q] - shape["x", self.p]
        per_v, per_w = n.swapaxes(0, 1), cross(n, offset[:, None]).swapaxes(0, 1)
        return np.concatenate([-per_v, per_w, per_v], axis=1)

    def D2D(self, shape: Shape, velocity: Velocity) -> np.ndarray:
        """(3, N): second derivatives of the deformations while v_p, v_q and ω_r are constant."""
        n, w = compose(shape["R", self.r], self.triad), velocity["R", self.r]
        offset = shape["x", self.q] - shape["x", self.p]
        _, dn, ddn = turning(w, n)
        return unrotate(ddn, offset) + 2 * unrotate(dn, velocity["x", self.q] - velocity["x", self.p])

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
