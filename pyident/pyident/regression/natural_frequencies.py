"""How fast each hinge vibrates: what the samples of a log can tell of its damping, and what they cannot."""

from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.regressor import generalised_forces

_POSES = 5  # of a motion, evenly spaced


def natural_frequencies(robot: Robot, motion: Motion) -> dict[str, float]:
    """Deformation, `joint1.eps[1]` -> frequency [Hz] of the undamped mode that bends this hinge most.

    M(q) z̈ + K z = 0 with the robot's own parameters, the drives free, at some poses of the motion (N, n):
    the highest of them counts, infinite where nothing has mass. M is the part of Φ p that is linear in the
    accelerations.
    """
    from scipy.linalg import eig  # much memory, for few robots

    stiffness = {c: c.replace(".eps[", ".k[") for c in robot.coordinates if ".eps[" in c}
    K = np.diag([robot.parameters[stiffness[c]] if c in stiffness else 0.0 for c in robot.coordinates])
    found = dict.fromkeys(stiffness, 0.0)
    if not found:
        return found
    for at in np.linspace(0, len(motion.q) - 1, _POSES).astype(int):
        squares, modes = eig(K, _mass_matrix(robot, motion, int(at)))  # pyright: ignore[reportAssignmentType]
        squares = np.nan_to_num(np.real(squares), nan=0.0, posinf=np.inf)  # of what has no mass
        hertz = np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)
        energy = np.diag(K)[:, None] * np.abs(modes) ** 2
        share = energy / np.maximum(energy.sum(axis=0), 1e-300) * (hertz > 0)
        for i, c in enumerate(robot.coordinates):
            if c in found:
                found[c] = max(found[c], float(hertz[int(np.argmax(share[i]))]))
    return found


def _mass_matrix(robot: Robot, motion: Motion, at: int) -> np.ndarray:
    """(n, n), from the forces of one unit of every acceleration less those of none."""
    n = len(robot.coordinates)
    rest, units = np.zeros((n + 1, n)), np.vstack([np.zeros(n), np.eye(n)])

    def held(signal: np.ndarray | None) -> np.ndarray | None:
        return None if signal is None else np.repeat(signal[at : at + 1], n + 1, axis=0)

    pose = np.repeat(motion.q[at : at + 1], n + 1, axis=0)
    still = replace(motion, q=pose, dq=rest, ddq=units, tau=held(motion.tau), time=held(motion.time))
    still = replace(still, tau_before=held(motion.tau_before))
    p = np.array(list(robot.linear_parameters.values()))
    forces = generalised_forces(robot, still, p)
    return (forces[1:] - forces[0]).T
