"""Unit quaternions (x, y, z, w) in CasADi, the order of ROS messages."""

from typing import Any

import casadi as ca
import numpy as np

SX = Any  # casadi.SX; its stubs do not describe operators

NONE = ca.SX(np.array([0.0, 0.0, 0.0, 1.0]))


def about(axis: np.ndarray, angle: SX) -> SX:
    """Turned by `angle` [rad] about the unit vector `axis`."""
    return ca.vertcat(axis * ca.sin(angle / 2), ca.cos(angle / 2))


def bent(y: SX, z: SX) -> SX:
    """The shortest rotation that takes (1, 0, 0) to (c, y, z)."""
    c = ca.sqrt(1 - y**2 - z**2)
    return ca.vertcat(0, -z, y, 1 + c) / ca.sqrt(2 * (1 + c))


def product(a: SX, b: SX) -> SX:
    """First b, then a."""
    vector = a[3] * b[:3] + b[3] * a[:3] + ca.cross(a[:3], b[:3])
    return ca.vertcat(vector, a[3] * b[3] - ca.dot(a[:3], b[:3]))


def seen_from(axes: np.ndarray, q: SX) -> SX:
    """The rotation q (4, scalar last) in base axes; `axes` (3, 3) holds the axes of q in its columns."""
    return ca.vertcat(axes @ q[:3], q[3])
