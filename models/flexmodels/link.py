"""A rigid body lumped at its joint."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

LINK_PARAMETERS: dict[str, str] = {
    "m": "kg",
    **{f"ms[{a}]": "kg.m" for a in "xyz"},
    **{f"J[{ab}]": "kg.m2" for ab in ("xx", "xy", "xz", "yy", "yz", "zz")},
}


@dataclass(frozen=True)
class Link:
    """A rigid body lumped at its joint, eq. (1): mass [kg], first moments [kg m], inertia [kg m2]."""

    m: float
    ms: tuple[float, ...]
    J: tuple[float, ...]  # xx, xy, xz, yy, yz, zz about the joint

    @property
    def values(self) -> dict[str, float]:
        return dict(zip(LINK_PARAMETERS, (self.m, *self.ms, *self.J), strict=True))

    @staticmethod
    def of_values(values: Mapping[str, float]) -> "Link":
        p = [float(values[name]) for name in LINK_PARAMETERS]
        return Link(p[0], tuple(p[1:4]), tuple(p[4:]))

    @staticmethod
    def of_centre(m: float, com: np.ndarray, J_com: np.ndarray) -> "Link":
        """From the centre of mass [m] and the 3 x 3 inertia about it [kg m2] (parallel axes)."""
        J = J_com + m * (com @ com * np.eye(3) - np.outer(com, com))
        return Link(
            float(m), tuple(float(v) for v in m * com), tuple(float(v) for v in J[np.triu_indices(3)])
        )

    def about_centre(self) -> tuple[np.ndarray, np.ndarray]:
        """The centre of mass [m] and the 3 x 3 inertia about it [kg m2]; of a link that has a mass."""
        com = np.array(self.ms) / self.m
        xx, xy, xz, yy, yz, zz = self.J
        J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return com, J - self.m * (com @ com * np.eye(3) - np.outer(com, com))
