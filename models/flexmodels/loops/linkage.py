"""What closes a loop: joints without a motor, and the pins that tie links together.

Two descriptions of the same thing, kept apart on purpose: the plant turns a passive joint by `follows`,
pyident's finite elements know only the pin and find the angle themselves.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class PassiveJoint:
    """A hinge that carries a link but has no motor, no flexible hinge and no laws.

    x, y      hinge triad in the zero pose (z = x cross y)
    origin    from the joint of the parent link [m]
    follows   driven joint (from 1) -> factor: its angle is the sum of factor times (e + eps[1]) of each
    parent    number of the link that it sits on, 0 for the base; None takes the link before
    geared    turned by a gear or a belt; else pins (closures) make it follow
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    origin: tuple[float, ...]
    follows: Mapping[int, float]
    parent: int | None = None
    geared: bool = False

    @property
    def triad(self) -> np.ndarray:
        """3 x 3, columns x', y', z' in base axes."""
        x, y = np.array(self.x), np.array(self.y)
        return np.column_stack([x, y, np.cross(x, y)])


@dataclass(frozen=True)
class Closure:
    """A revolute pin between two links: at `point` [m], about `axis`, base axes in the zero pose.

    The first link is the rod: it hangs in its own passive joint at one end and in this pin at the other.
    """

    links: tuple[int, int]
    point: tuple[float, ...]
    axis: tuple[float, ...]
