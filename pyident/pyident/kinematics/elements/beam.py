"""The beam element: elongation, torsion and four bendings between two nodes with triads.

Deformation functions of Jonker (1990), each a length [m]. With the unit vector u from p to q, the
distance l and its value l0 in the reference configuration:

    e1 = l − l0                              e2 = l0 (n_z^p·n_y^q − n_y^p·n_z^q) / 2
    e3 = −l0 u·n_z^p,   e4 = l0 u·n_z^q      e5 = l0 u·n_y^p,   e6 = −l0 u·n_y^q

A rigid link holds all six at zero.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyident.kinematics.elements.nodes import Deformation, Node, Nodes, Position, Shape, Velocity
from pyident.kinematics.elements.triads import axes, compose, cross, dot, rotate, second_rate, turning


@dataclass(frozen=True)
class Beam:
    """Translational nodes p and q, rotational nodes r at p and s at q; vector (3,) from p to q [m]."""

    p: int
    r: int
    q: int
    s: int
    vector: np.ndarray
    modes = 6
    turns = ()

    def __post_init__(self) -> None:
        if not np.linalg.norm(self.vector) > 0:
            raise ValueError(f"the beam from node {self.p} to {self.q} has no length; make them one node")

    @property
    def inner(self) -> tuple[Node, ...]:
        return ("x", self.p), ("R", self.r)

    @property
    def outer(self) -> tuple[Node, ...]:
        return ("x", self.q), ("R", self.s)

    @cached_property
    def triad(self) -> np.ndarray:
        """x' from p to q, y' and z' across it; a rigid beam does not care which."""
        x = self.vector / np.linalg.norm(self.vector)
        y = np.cross(np.eye(3)[np.abs(x).argmin()], x)
        y /= np.linalg.norm(y)
        return np.column_stack([x, y, np.cross(x, y)])

    def D(self, shape: Shape) -> np.ndarray:
        """Deformations e1 to e6 (6, N) [m]."""
        l0, length, u, n_p, n_q = self._geometry(shape)
        (_, yp, zp), (_, yq, zq) = axes(n_p), axes(n_q)
        torsion = (dot(zp, yq) - dot(yp, zq)) / 2
        return np.stack([length - l0, l0 * torsion, *(l0 * dot(u, n) for n in (-zp, zq, yp, -yq))])

    def DD(self, shape: Shape) -> np.ndarray:
        """(6, 12, N): rates of the deformations per unit of v_p, ω_r, v_q and ω_s."""
        l0, length, u, n_p, n_q = self._geometry(shape)
        (_, yp, zp), (_, yq, zq) = axes(n_p), axes(n_q)
        per_v, per_wp, per_wq = np.zeros((3, 6, *u.shape))
        per_v[0] = u
        per_wq[1] = l0 / 2 * (cross(yq, zp) - cross(zq, yp))
        per_wp[1] = -per_wq[1]
        for mode, n, per_w in ((2, -zp, per_wp), (3, zq, per_wq), (4, yp, per_wp), (5, -yq, per_wq)):
            per_v[mode] = l0 / length * (n - u * dot(u, n))
            per_w[mode] = l0 * cross(n, u)
        return np.concatenate([-per_v, per_wp, per_v, per_wq], axis=1)

    def D2D(self, shape: Shape, velocity: Velocity) -> np.ndarray:
        """(6, N): second derivatives of the deformations while the nodal velocities are constant."""
        l0, length, u, n_p, n_q = self._geometry(shape)
        _, yp, zp = axes(turning(velocity["R", self.r], n_p))
        _, yq, zq = axes(turning(velocity["R", self.s], n_q))
        v = velocity["x", self.q] - velocity["x", self.p]
        rate = dot(u, v)
        du = (v - u * rate) / length
        elongation = length * dot(du, du)
        along = np.stack([u, du, -(2 * du * rate + u * elongation) / length])
        torsion = (second_rate(zp, yq) - second_rate(yp, zq)) / 2
        return np.stack([elongation, l0 * torsion, *(l0 * second_rate(along, n) for n in (-zp, zq, yp, -yq))])

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

    def _geometry(self, shape: Shape) -> tuple[float, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """l0, l (N,), u (3, N) and the triads at p and q (3, 3, N)."""
        span = shape["x", self.q] - shape["x", self.p]
        length = np.sqrt(dot(span, span))
        n_p, n_q = (compose(shape["R", node], self.triad) for node in (self.r, self.s))
        return float(np.linalg.norm(self.vector)), length, span / length, n_p, n_q
