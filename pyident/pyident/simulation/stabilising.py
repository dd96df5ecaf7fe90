"""A controller that follows a measured motion, where nothing is known of the one that made it."""

import numpy as np

from flexmodels.robot import Robot
from flexmodels.settings.controller import Controller
from pyident.conditioning.motion import Motion
from pyident.regression.regressor import generalised_forces

_BANDWIDTH = 10.0  # Hz
_SAMPLED = 0.02  # of the sampling rate, that the bandwidth is at most
_POSES = 40  # of a motion, at which the arm's inertia is taken
_FASTEST = 1.6  # of a speed, that damping takes within a sample in any pose; with 2 a loop swings for ever


def stabilising_controller(robot: Robot, q: np.ndarray, period: float) -> Controller:
    """PD gains that follow a motion q (N, n) at a bandwidth of about 10 Hz, from the model's mass matrix M.

    A joint's inertia is 1 / (M⁻¹)_kk, what it moves while the others give way: the loop's squared frequencies
    then add up to as many times ω² as there are joints. By M_kk wrists whose axes align shake far faster. It
    changes with the pose, where an arm stretches by more than ten times, and gains for one pose may shake the
    arm in another: they are for what lies midway between its extremes, and small enough for all poses.
    """
    joints = len(robot.joints)
    omega = 2 * np.pi * min(_BANDWIDTH, _SAMPLED / period)
    M = _mass_matrices(robot, q[np.unique(np.linspace(0, len(q) - 1, _POSES).astype(int))])
    inverse = np.linalg.pinv(M, hermitian=True)
    free = np.diagonal(inverse, axis1=1, axis2=2)
    free = np.where(free > 0, 1 / np.where(free > 0, free, 1.0), np.diagonal(M, axis1=1, axis2=2))
    inertia = np.sqrt(np.abs(free).min(axis=0) * np.abs(free).max(axis=0))
    rate = 2 * omega * period * float(np.abs(np.linalg.eigvals(inverse * inertia)).max())
    inertia = inertia * min(1.0, _FASTEST / max(rate, 1e-300))
    Kp, Kd = (inertia * omega**2).tolist(), (2 * inertia * omega).tolist()
    return Controller(1 / period, tuple(Kp), tuple(Kd), (0.0,) * joints)


def _mass_matrices(robot: Robot, q: np.ndarray) -> np.ndarray:
    """(N, joints, joints) of the motors, their hinges stiff, at q (N, n)."""
    joints, p = len(robot.joints), np.array(list(robot.linear_parameters.values()))
    at = np.repeat(q, joints + 1, axis=0)
    rest, units = np.zeros_like(at), np.zeros((joints + 1, q.shape[1]))
    units[range(joints), range(joints)] = 1.0
    motion = Motion(at, rest, np.tile(units, (len(q), 1)), rest[:, :joints], np.zeros(len(at)))
    forces = generalised_forces(robot, motion, p)[:, :joints].reshape(len(q), joints + 1, joints)
    return forces[:, :joints] - forces[:, joints:]
