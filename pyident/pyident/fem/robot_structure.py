"""The finite elements of a robot, figure 1 of the paper."""

import numpy as np

from flexmodels.robot import Robot
from pyident.fem.beam import Beam
from pyident.fem.hinge import Hinge
from pyident.fem.slider import Slider
from pyident.fem.structure import Element, Mode, Structure


def of_robot(robot: Robot) -> Structure:
    """Per joint: a beam from the previous joint, the motor hinge (or slider), the flexible hinge if any.

    The structure's q is in the order of `robot.coordinates`, its bodies in that of `robot.links`.
    """
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
    independent = tuple(place[name] for name in robot.coordinates)
    return Structure(tuple(elements), independent, bodies=tuple(bodies))
