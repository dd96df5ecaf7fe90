"""What a fit leaves of torques at the frequencies at which they move.

Above is the noise of positions, of which splines that move them by a part of a sample make more or less. So
two fits of positions that one of them has moved are compared below.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_MOSTLY = 0.95  # of the torques' power lies below where they move


@dataclass(frozen=True)
class Rest:
    """Per log what is left of the torques (N, joints) [N m], these, and the period [s] of the samples."""

    left: Sequence[np.ndarray]
    torques: Sequence[np.ndarray]
    periods: Sequence[float]

    @property
    def in_motion(self) -> float:
        """Mean square of what is left of all torques where they move, over theirs."""
        found = [_powers(*log) for log in zip(self.left, self.torques, self.periods, strict=True)]
        left, whole = np.sum(found, axis=0)
        return float(left / whole) if whole > 0 else 0.0


def _powers(left: np.ndarray, torques: np.ndarray, period: float) -> tuple[float, float]:
    """Power of what is left at frequencies up to those at which torques move, and of these, of all joints."""
    whole = np.square(np.abs(np.fft.rfft(torques - torques.mean(axis=0), axis=0))).sum(axis=1)
    below = np.cumsum(whole)
    moving = slice(int(np.searchsorted(below, _MOSTLY * below[-1])) + 1)
    lines = np.square(np.abs(np.fft.rfft(left, axis=0)))[moving]
    return float(lines.sum()) * period**2, float(below[-1]) * period**2
