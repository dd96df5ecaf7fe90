"""What the arm carries beyond its own links: a rigid body whose centre is given from the tip."""

from typing import Any

import casadi as ca
import numpy as np

from flexmodels.link import LINK_PARAMETERS

SX = Any  # casadi.SX; its stubs do not describe operators

_AXES = ("xx", "xy", "xz", "yy", "yz", "zz")
# Name -> unit and description; zero unless set.
PAYLOAD: dict[str, tuple[str, str]] = {
    "payload.m": ("kg", "Mass of the payload"),
    **{f"payload.c[{a}]": ("m", f"Centre of the payload from the tip, component {a}") for a in "xyz"},
    **{f"payload.J[{ab}]": ("kg.m2", f"Inertia of the payload about its centre, {ab}") for ab in _AXES},
}


def carried(p: SX, tip: np.ndarray) -> SX:
    """What a payload (m, c, J) adds to LINK_PARAMETERS of the link that carries it; parallel axes."""
    m, c, J = p[0], p[1:4] + tip, p[4:]
    about_joint = m * (ca.dot(c, c) * ca.SX.eye(3) - c @ c.T)
    shift = [about_joint["xyz".index(a), "xyz".index(b)] for a, b in _AXES]
    out = ca.vertcat(m, m * c, J + ca.vertcat(*shift))
    assert out.numel() == len(LINK_PARAMETERS)
    return out
