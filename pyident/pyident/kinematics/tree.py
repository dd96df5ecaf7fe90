"""A robot with passive joints as an open tree, whose hinges turn by themselves.

What `follows` says of passive joints is linear in the coordinates, so that all forces along a motion of the
robot are those of the tree along the motion that this asks of it. Gears do that by what they are. Pins do it
where the loop that they close is a parallelogram, and `follows` is right: the finite elements, which know the
pins alone, must agree.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexmodels.joint import Joint
from flexmodels.robot import Robot
from pyident.kinematics import chain, loop
from pyident.kinematics.robot_structure import of_robot
from pyident.kinematics.structure import ReachError, Structure

_POSES, _SWING = 8, 0.3  # that are tried, and how far every coordinate goes there [rad, m]
_EQUAL = 1e-6  # m, and of a unit vector


@dataclass(frozen=True)
class Tree:
    """robot: with every passive joint driven, and no pins;  turns: (m, n) its coordinates per unit of the
    other robot's, which has `loops`, its finite elements with their pins; None where gears turn a joint.
    """

    robot: Robot
    turns: np.ndarray
    loops: Structure | None

    @cached_property
    def structure(self) -> Structure:
        return of_robot(self.robot)

    @property
    def pinned(self) -> Structure:
        """Its loops; the tree itself where there are none to ask."""
        return self.loops or self.structure

    def agrees(self) -> bool:
        """Whether the pins turn the passive joints likewise, wherever joints and hinges stand.

        A motion is no proof: one that hardly bends a hinge hides that its bend would tilt a rod.
        """
        if self.loops is None:
            return True
        q = np.random.default_rng(0).uniform(-_SWING, _SWING, (self.turns.shape[1], _POSES))
        still, at_rest = np.zeros_like(q), np.zeros((len(self.turns), _POSES))
        try:
            pinned = loop.nodes(self.loops, q, still, still)
        except ReachError:
            return False
        hung = chain.nodes(self.structure, self.turns @ q, at_rest, at_rest)
        return all(
            np.allclose(pinned.positions[x].x, hung.positions[tx].x, atol=_EQUAL, rtol=0)
            and np.allclose(pinned.orientations[R].R, hung.orientations[tR].R, atol=_EQUAL, rtol=0)
            for (x, R), (tx, tR) in zip(self.loops.bodies, self.structure.bodies, strict=True)
        )


def tree_of(robot: Robot) -> Tree:
    """The tree of a robot with passive joints. Raises StructureError."""
    hinges = [Joint("revolute", j.x, j.y, j.origin, False, {}, parent=j.parent) for j in robot.passive]
    tree = replace(robot, joints=(*robot.joints, *hinges), passive=(), closures=(), transmission=None)
    names, motors = list(robot.coordinates), len(robot.joints)
    turns = np.zeros((len(tree.q), len(names)))
    for row, coordinate in zip(turns, tree.q, strict=True):
        if coordinate.joint > motors:
            row[:] = robot.following[coordinate.joint - motors - 1]
        else:
            row[names.index(coordinate.name)] = 1.0
    geared = any(joint.geared for joint in robot.passive)
    return Tree(tree, turns, None if geared else of_robot(robot))
