"""The lumped body of a link: its inertia reaction as a linear function of its ten parameters, eq. (1)."""

import numpy as np

from pyident.kinematics.elements.nodes import Orientation, Position
from pyident.kinematics.elements.triads import compose, cross, unrotate


def reaction(position: Position, orientation: Orientation, gravity: np.ndarray) -> np.ndarray:
    """The body's M x'' − f per unit of m, ms (3), J (xx, xy, xz, yy, yz, zz): (6, 10, N), base axes.

    Rows are the force [N] and the moment about the node [N m] that the body takes from the structure,
    gravity (3,) [m/s²] included; parameters are along the link's axes, moments of mass about the node.
    """
    R = orientation.R
    a = position.a - gravity[:, None]
    w, dw = orientation.w[:, None], orientation.dw[:, None]
    Y = np.zeros_like(a, shape=(6, 10, a.shape[-1]))
    Y[:3, 0] = a
    Y[:3, 1:4] = cross(dw, R) + cross(w, cross(w, R))
    Y[3:, 1:4] = cross(R, a[:, None])
    Y[3:, 4:] = compose(R, _moment_of_inertia(unrotate(R, orientation.w), unrotate(R, orientation.dw)))
    return Y


def _moment_of_inertia(w: np.ndarray, dw: np.ndarray) -> np.ndarray:
    """J dω + ω × J ω per unit of Jxx, Jxy, Jxz, Jyy, Jyz, Jzz, in the link's axes: (3, 6, N)."""
    (x, y, z), (dx, dy, dz) = w, dw
    xy, yz, zx = x * y, y * z, z * x
    xx, yy, zz = x * x, y * y, z * z
    return np.stack(
        [
            np.stack([dx, dy - zx, dz + xy, -yz, yy - zz, yz]),
            np.stack([zx, dx + yz, zz - xx, dy, dz - xy, -zx]),
            np.stack([-xy, xx - yy, dx - yz, xy, dy + zx, dz]),
        ]
    )
