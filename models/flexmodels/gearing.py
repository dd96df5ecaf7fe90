"""What lies between the motors and the joints: ratios, couplings, offsets, drive gains."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Transmission:
    """Motor angles are R (q - offset), joint torques Rᵀ times those of the motors.

    ratio   n x n, R: turns of motor i per turn of joint j
    offset  joint angle where the motors read zero [rad or m], (n,)
    drive   motor torque per unit of current [N m/A], (n,); None where the torque itself is logged
    """

    ratio: tuple[tuple[float, ...], ...]
    offset: tuple[float, ...]
    drive: tuple[float, ...] | None = None

    def angles(self, motors: np.ndarray) -> np.ndarray:
        """Joint angles (N, n) of motor angles (N, n)."""
        return np.linalg.solve(np.array(self.ratio), motors.T).T + np.array(self.offset)

    def torques(self, motors: np.ndarray) -> np.ndarray:
        """Joint torques (N, n) of motor torques (N, n)."""
        return motors @ np.array(self.ratio)
