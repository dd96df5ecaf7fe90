"""The finite elements of a robot, figure 1 of the paper; closed loops after Jonker (1990)."""

import numpy as np

from flexmodels.coordinate import deformation_of, motor_of
from flexmodels.loops.linkage import Closure
from flexmodels.robot import Robot
from pyident.kinematics.elements.beam import Beam
from pyident.kinematics.elements.hinge import Hinge
from pyident.kinematics.elements.slider import Slider
from pyident.kinematics.structure import Element, Mode, Structure, StructureError

End = tuple[int, int]  # a translational and a rotational node


def of_robot(robot: Robot) -> Structure:
    """Per joint: a beam from the parent's joint, the motor hinge (or slider), the flexible hinge if any.

    A passive joint is a hinge whose twist is released; a closure ties two links by one more. What turns the
    passive joints is found from the pins alone, never from `follows`. The structure's q is in the order of
    `robot.coordinates`, its bodies in that of `robot.links`. Raises StructureError.
    """
    if any(joint.geared for joint in robot.passive):
        raise StructureError(
            f"robot {robot.name} has a joint that a gear turns, which no finite element does; use its tree"
        )
    parts, place, ends = _Parts(), {}, [(0, 0)]
    for (k, joint), parent in zip(robot.numbered, robot.parents, strict=False):
        at = parts.beam(ends[parent], np.array(joint.origin))
        place[motor_of(k)] = (len(parts.elements), 0)
        at = (parts.hinge if joint.kind == "revolute" else parts.slider)(at, joint.triad)
        if joint.flexible:
            place |= {deformation_of(k, i): (len(parts.elements), i - 1) for i in joint.deformations}
            at = parts.hinge(at, joint.triad)
        ends.append(at)
    passive: dict[int, int] = {}  # link -> the hinge that carries it
    for k, joint in enumerate(robot.passive, start=len(ends)):
        at = parts.beam(ends[robot.parents[k - 1]], np.array(joint.origin))
        passive[k] = len(parts.elements)
        parts.released.append((passive[k], 0))
        ends.append(parts.hinge(at, joint.triad))
    joints = _zero_pose(robot)
    for closure in robot.closures:
        (a, b), point = closure.links, np.array(closure.point)
        if a not in passive:
            raise StructureError(
                f"the closure of links {a} and {b} needs a passive first link; name the rod first"
            )
        parts.released += [(passive[a], 1), (passive[a], 2)]
        parts.close(closure, (ends[a], ends[b]), (point - joints[a], point - joints[b]))
    independent = tuple(place[name] for name in robot.coordinates)
    return Structure(tuple(parts.elements), independent, tuple(parts.released), tuple(ends[1:]))


class _Parts:
    """Elements and released modes so far; each method adds an element and says where it ends."""

    def __init__(self) -> None:
        self.elements: list[Element] = []
        self.released: list[Mode] = []
        self.x = self.R = 0  # the last translational and rotational node

    def beam(self, at: End, vector: np.ndarray) -> End:
        if not any(vector):
            return at
        self.x, self.R = self.x + 1, self.R + 1
        self.elements.append(Beam(*at, self.x, self.R, vector))
        return self.x, self.R

    def hinge(self, at: End, triad: np.ndarray) -> End:
        self.R += 1
        self.elements.append(Hinge(at[1], self.R, triad))
        return at[0], self.R

    def slider(self, at: End, triad: np.ndarray) -> End:
        self.x += 1
        self.elements.append(Slider(*at, self.x, triad))
        return self.x, at[1]

    def close(self, closure: Closure, ends: tuple[End, End], arms: tuple[np.ndarray, np.ndarray]) -> None:
        """The pin: a rigid arm to it on either link, a free hinge between the arms.

        A planar loop in space is held three times too often, so the rod gets a ball joint at its own end
        (released by the caller) and a universal joint here: it may tilt across itself, not spin.
        """
        (rod, other), (along, arm) = ends, arms
        if not any(arm):
            raise StructureError("the pin of a closure lies in the joint of its second link; move its point")
        triad = _across(along, np.array(closure.axis))
        pin = self.beam(rod, along)
        self.released += [(len(self.elements), 0), (len(self.elements), 1)]
        x, R = self.hinge(pin, triad)
        self.elements.append(Beam(*other, x, R, arm))


def _across(rod: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Triad of a pin: x' its axis, y' along the rod, so that its second deformation is a tilt across it."""
    y = rod - axis * (axis @ rod)
    if np.linalg.norm(y) < 1e-9:
        raise StructureError("the pin of a closure lies on the axis of its rod's own joint; move its point")
    y /= np.linalg.norm(y)
    return np.column_stack([axis, y, np.cross(axis, y)])


def _zero_pose(robot: Robot) -> list[np.ndarray]:
    """Where the base and the joint of every link are while all coordinates are zero [m]."""
    places = [np.zeros(3)]
    for joint, parent in zip((*robot.joints, *robot.passive), robot.parents, strict=True):
        places.append(places[parent] + np.array(joint.origin))
    return places
