"""The geometric transfer function x = F(q) and its derivatives, eqs (5)-(7)."""

import numpy as np

from flexmodels.robot import Robot
from pyident.kinematics import chain, loop
from pyident.kinematics.elements.nodes import Nodes
from pyident.kinematics.elements.triads import rotate
from pyident.kinematics.robot_structure import of_robot
from pyident.kinematics.structure import Structure
from pyident.kinematics.tree import tree_of


def nodes(structure: Structure, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> Nodes:
    """The motion of every node for q, dq, ddq (n, N): a chain by recursion, a loop by Newton iteration."""
    method = chain if structure.is_chain else loop
    return method.nodes(structure, q, dq, ddq)


def tip_positions(robot: Robot, q: np.ndarray) -> np.ndarray:
    """The robot's tip in base axes [m], (N, 3), for q (N, n) in the order of `robot.coordinates`."""
    if any(joint.geared for joint in robot.passive):
        tree = tree_of(robot)
        return tip_positions(tree.robot, q @ tree.turns.T)
    structure, still = of_robot(robot), np.zeros_like(q.T)
    found = nodes(structure, q.T, still, still)
    x, R = structure.bodies[-1 if robot.tip_link is None else robot.tip_link - 1]
    return (found.positions[x].x + rotate(found.orientations[R].R, np.array(robot.tip))).T
