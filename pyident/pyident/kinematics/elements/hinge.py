"""The hinge element: a large rotation e1 about x' and two bendings e2, e3 between two rotational nodes.

Seen from the inner triad n^p, the outer axis n_x^q is (c, e2, e3) with c = √(1 − e2² − e3²): it bends
there by the shortest rotation B, then the outer triad twists about it by e1. So n^q = n^p B Rx(e1).
After Geradin et al. (1986), Schwab and Meijaard (1999).
"""

from dataclasses import dataclass

import numpy as np

from pyident.kinematics.elements.nodes import Deformation, Node, Nodes, Orientation, Shape, Velocity
from pyident.kinematics.elements.triads import (
    about_x,
    axes,
    compose,
    cross,
    dot,
    rotate,
    second_rate,
    turning,
)


@dataclass(frozen=True)
class Hinge:
    """Rotational nodes p and q; triad (3, 3): columns x', y', z' in base axes, x' the hinge axis."""

    p: int
    q: int
    triad: np.ndarray
    modes = 3
    turns = (0,)

    @property
    def inner(self) -> tuple[Node, ...]:
        return (("R", self.p),)

    @property
    def outer(self) -> tuple[Node, ...]:
        return (("R", self.q),)

    def D(self, shape: Shape) -> np.ndarray:
        """Deformations e1, e2, e3 (3, N)."""
        return deformations(*self._triads(shape))

    def DD(self, shape: Shape) -> np.ndarray:
        """(3, 6, N): rates of the deformations per unit of ω_p and ω_q."""
        (xp, yp, zp), (xq, _, _) = (axes(n) for n in self._triads(shape))
        per_w = np.stack([(xp + xq) / (1 + dot(xp, xq)), cross(xq, yp), cross(xq, zp)])
        return np.concatenate([-per_w, per_w], axis=1)

    def D2D(self, shape: Shape, velocity: Velocity) -> np.ndarray:
        """(3, N): second derivatives of the deformations while ω_p and ω_q are constant."""
        n_p, n_q = self._triads(shape)
        w_p, w_q = velocity["R", self.p], velocity["R", self.q]
        (xp, yp, zp), (xq, _, _) = axes(turning(w_p, n_p)), axes(turning(w_q, n_q))
        double = xp + xq
        c, dc = 1 + dot(xp[0], xq[0]), dot(xp[1], xq[0]) + dot(xp[0], xq[1])
        twist = dot(double[1] - double[0] * dc / c, w_q - w_p) / c
        return np.stack([twist, second_rate(yp, xq), second_rate(zp, xq)])

    def _triads(self, shape: Shape) -> tuple[np.ndarray, np.ndarray]:
        return compose(shape["R", self.p], self.triad), compose(shape["R", self.q], self.triad)

    def carry(self, nodes: Nodes, d: Deformation) -> None:
        """Find node q from node p: R, then ω_q = ω_p + A de, then its derivative."""
        p = nodes.orientations[self.p]
        n = compose(p.R, self.triad)
        if d.columns[1] is None and d.columns[2] is None:  # no bending: a plain rotation about x'
            relative, A, convective = about_x(d.e[0]), n[:, :1], np.zeros_like(p.w)
        else:
            relative, A = relative_rotation(d.e), compose(n, rate_axes(d.e))
            convective = rotate(n, convective_rate(d.e, d.de))
        modes = A.shape[1]
        w = rotate(A, d.de[:modes])
        DF = p.DF.copy()
        for mode, column in enumerate(d.columns[:modes]):
            if column is not None:
                DF[:, column] = A[:, mode]
        nodes.orientations[self.q] = Orientation(
            R=compose(compose(n, relative), self.triad.T),
            w=p.w + w,
            dw=p.dw + rotate(A, d.dde[:modes]) + cross(p.w, w) + convective,
            DF=DF,
        )


def deformations(n_p: np.ndarray, n_q: np.ndarray) -> np.ndarray:
    """D(x): e1, e2, e3 (3, N) [rad, -, -] of the triads n^p and n^q (3, 3, N)."""
    (_, yp, zp), (xq, yq, zq) = axes(n_p), axes(n_q)
    e1 = np.arctan2(dot(zp, yq) - dot(yp, zq), dot(yp, yq) + dot(zp, zq))
    return np.stack([e1, dot(yp, xq), dot(zp, xq)])


def relative_rotation(e: np.ndarray) -> np.ndarray:
    """The inverse of D: n^pᵀ n^q = B(e2, e3) Rx(e1), (3, 3, N), of deformations e (3, N)."""
    _, e2, e3 = e
    c = _cosine(e)
    a = 1 / (1 + c)
    B = np.empty_like(e, shape=(3, *e.shape))
    B[0, 0], B[0, 1], B[0, 2] = c, -e2, -e3
    B[1, 0], B[1, 1], B[1, 2] = e2, 1 - a * e2**2, -a * e2 * e3
    B[2, 0], B[2, 1], B[2, 2] = e3, B[1, 2], 1 - a * e3**2
    return compose(B, about_x(e[0]))


def rate_axes(e: np.ndarray) -> np.ndarray:
    """S (3, 3, N): the relative angular velocity in the axes of n^p is S de."""
    _, e2, e3 = e
    c = _cosine(e)
    a, b = 1 / (1 + c), 1 / (c * (1 + c))
    S = np.empty_like(e, shape=(3, *e.shape))
    S[:, 0] = c, e2, e3
    S[:, 1] = -a * e3, -b * e2 * e3, 1 + b * e2**2
    S[:, 2] = a * e2, -1 - b * e3**2, b * e2 * e3
    return S


def convective_rate(e: np.ndarray, de: np.ndarray) -> np.ndarray:
    """(dS/dt) de (3, N): what dde = 0 leaves of the relative angular acceleration, in axes of n^p.

    With n = (c, e2, e3) the relative angular velocity is S de = (de1 − t) n + n × dn, where
    t = (e2 de3 − e3 de2) / (1 + c) is the turn about n that the shortest rotation B makes by itself.
    """
    (_, e2, e3), (de1, de2, de3) = e, de
    c = _cosine(e)
    dc = -(e2 * de2 + e3 * de3) / c
    ddc = -(dc**2 + de2**2 + de3**2) / c
    t = (e2 * de3 - e3 * de2) / (1 + c)
    dt = -t * dc / (1 + c)
    n, dn = np.stack([c, e2, e3]), np.stack([dc, de2, de3])
    n_cross_ddn = np.stack([np.zeros_like(c), e3 * ddc, -e2 * ddc])
    return (de1 - t) * dn - dt * n + n_cross_ddn


def check_bend(e: np.ndarray) -> None:
    """Raises ValueError where deformations e (3, N) bend the hinge by a right angle."""
    bend = np.sqrt(e[1] ** 2 + e[2] ** 2).max(initial=0.0)
    if not bend < 1:
        raise ValueError(
            f"a hinge is bent by {bend:.3g}, but bendings stay below 1; check that eps is in rad"
        )


def _cosine(e: np.ndarray) -> np.ndarray:
    """c, the cosine of the bending angle."""
    if e.dtype != object:  # symbols are checked when they get their values
        check_bend(e)
    return np.sqrt(1 - e[1] ** 2 - e[2] ** 2)
