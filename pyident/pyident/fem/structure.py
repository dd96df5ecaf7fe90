"""A mechanism as data: nodes, the elements that share them, and what each deformation is."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from flexmodels.robot import Robot

from pyident.fem.beam import Beam
from pyident.fem.hinge import Hinge
from pyident.fem.slider import Slider

Element = Beam | Hinge | Slider
Mode = tuple[int, int]  # number of the element, number of its deformation, both from 0


@dataclass(frozen=True)
class Structure:
    """Elements listed from the ground outwards. Translational and rotational nodes 0 are the ground.

    independent   the deformations that are the degrees of freedom, in the order of q
    bodies        per lumped body its translational and its rotational node
    Every deformation that is not independent is fixed at zero.
    """

    elements: tuple[Element, ...]
    independent: tuple[Mode, ...]
    bodies: tuple[tuple[int, int], ...] = ()

    @cached_property
    def columns(self) -> tuple[tuple[int | None, ...], ...]:
        """Per element and mode its place in q, None where fixed."""
        place = {mode: j for j, mode in enumerate(self.independent)}
        return tuple(
            tuple(place.get((i, mode)) for mode in range(element.modes))
            for i, element in enumerate(self.elements)
        )


def of_robot(robot: Robot) -> Structure:
    """Per joint: a beam from the previous joint, the motor hinge (or slider), the flexible hinge if any."""
    elements: list[Element] = []
    place: dict[str, Mode] = {}
    bodies: list[tuple[int, int]] = []
    x, R = 0, 0
    for k, joint in robot.numbered:
        if any(joint.origin):
            elements.append(Beam(x, R, x + 1, R + 1, np.array(joint.origin)))
            x, R = x + 1, R + 1
        place[f"joint{k}.e"] = (len(elements), 0)
        if joint.kind == "revolute":
            elements.append(Hinge(R, R + 1, joint.triad))
            R += 1
        else:
            elements.append(Slider(x, R, x + 1, joint.triad))
            x += 1
        if joint.flexible:
            place |= {f"joint{k}.eps[{i + 1}]": (len(elements), i) for i in range(Hinge.modes)}
            elements.append(Hinge(R, R + 1, joint.triad))
            R += 1
        bodies.append((x, R))
    return Structure(tuple(elements), tuple(place[name] for name in robot.coordinates), tuple(bodies))
