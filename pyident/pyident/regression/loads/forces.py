"""Forces of a robot's links along a motion, for differences between robots or motions that hardly differ."""

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.kinematics import link_forces, robot_structure, transfer
from pyident.regression.loads.bodies import bodies
from pyident.regression.recent import Recent

_as_they_are: Recent[np.ndarray] = Recent(8)
_PIECE = 1000  # samples at a time: they stay in a core's cache


def as_they_are(robot: Robot, motion: Motion) -> np.ndarray:
    """(n, N) `link_forces_along` of what is asked for again and again [N m, N]."""
    return _as_they_are.of((robot, motion), lambda: link_forces_along(robot, motion))


def link_forces_along(robot: Robot, motion: Motion) -> np.ndarray:
    """(n, N) generalised forces of the links. By NumPy: compiling every geometry would take seconds each."""
    structure, gravity, own = robot_structure.of_robot(robot), np.array(robot.gravity), bodies(robot)
    rates = (np.ascontiguousarray(x.T) for x in (motion.q, motion.dq, motion.ddq))
    pieces = zip(*(np.array_split(x, range(_PIECE, x.shape[1], _PIECE), axis=1) for x in rates), strict=True)
    out = []
    for q, dq, ddq in pieces:
        found = transfer.nodes(structure, q, dq, ddq)
        factors = link_forces.factors(structure, found, gravity)
        out.append(
            sum(
                np.einsum("xin,xn->in", DF, np.einsum("xpn,p->xn", reaction, body))
                for body, (DF, reaction) in zip(own, factors, strict=True)
            )
        )
    return np.concatenate(out, axis=1)
