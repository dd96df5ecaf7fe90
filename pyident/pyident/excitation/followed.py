"""A reference as if it were followed exactly: its motion, small deformations, and the torques it takes."""

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.regressor import generalised_forces


def followed(robot: Robot, time: np.ndarray, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> Motion:
    """Motion (N samples) whose motor hinges follow q, dq, ddq (N, joints) at times [s].

    Deformations are those at which the stiffness carries the load of the stiff motion; their own inertia is
    left out. Torques are those of the robot's parameters.
    """
    joints, n = len(robot.joints), len(robot.coordinates)

    def wide(values: np.ndarray, deformations: np.ndarray | None = None) -> np.ndarray:
        out = np.zeros((len(time), n))
        out[:, :joints] = values
        if deformations is not None:
            out[:, joints:] = deformations
        return out

    stiff = Motion(wide(q), wide(dq), wide(ddq), np.zeros((len(time), joints)), time)
    forces = _forces(robot, stiff)
    if n == joints:
        return Motion(stiff.q, stiff.dq, stiff.ddq, forces, time)
    k = np.array([robot.parameters[c.stiffness or ""] for c in robot.q[joints:]])
    eps = -forces[:, joints:] / np.maximum(k, 1e-12)
    deps = np.gradient(eps, time, axis=0)
    ddeps = np.gradient(deps, time, axis=0)
    return Motion(wide(q, eps), wide(dq, deps), wide(ddq, ddeps), forces[:, :joints], time)


def torques(robot: Robot, motion: Motion) -> np.ndarray:
    """(N, joints) motor torques that the motion takes [N m or N], by the robot's own parameters."""
    return _forces(robot, motion)[:, : len(robot.joints)]


def _forces(robot: Robot, motion: Motion) -> np.ndarray:
    """(N, n) Φ p."""
    return generalised_forces(robot, motion, np.array(list(robot.linear_parameters.values())))
