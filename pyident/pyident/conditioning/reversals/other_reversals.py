"""Samples in which an equation holds what another joint does as it turns round.

Dry friction of a joint that turns round makes its acceleration a step, which links hand on to the other
joints. A motion without its noise has lost how fast that was, every coordinate beyond a corner of its own, so
that the equations of these joints hold bursts there: neither noise nor a law that the model lacks. They show
in a torque's highest frequencies. Where these hold far more beside the reversals of another joint than where
it keeps moving, such samples are left out.
"""

from collections.abc import Sequence

import numpy as np

from pyident.conditioning.motion import Motion
from pyident.conditioning.reversals.rest import stretches
from pyident.conditioning.reversals.torque_bends import telling
from pyident.conditioning.smooth_motion import blurred, smooth

_SHAKES = 2.0  # times the mean square of a torque's highest frequencies elsewhere
_MOST = 0.3  # of a joint's samples in motion that may be left out
_FEWEST = 0.2  # of them: where less is left, nothing tells what is usual


def all_telling(
    known: np.ndarray, torques: np.ndarray, motion: Motion, corners: Sequence[float], period: float
) -> np.ndarray:
    """(N, n) whether equations hold in a sample of a motion without its noise.

    known    (N, n) where friction's sign is known, as of `away_from_rest`
    torques  (N, n);  corners: of the coordinates, over the Nyquist frequency;  period [s]
    """
    joints = range(known.shape[1])
    each = [telling(known[:, k], torques[:, k], motion, k, corners[k], period) for k in joints]
    own = np.column_stack(each)
    return own & ~shaken(own, known, torques, corners)


def shaken(own: np.ndarray, known: np.ndarray, torques: np.ndarray, corners: Sequence[float]) -> np.ndarray:
    """(N, n) whether a torque is shaken by another joint that turns round.

    own   (N, n) where equations hold but for that;  the others as in `all_telling`
    """
    out = np.zeros(own.shape, bool)
    for k, moving in enumerate(own.T):
        lower = {j: min(corners[k], corners[j]) for j in range(own.shape[1]) if j != k}
        above = {corner: _above(torques[:, k], corner) for corner in set(lower.values())}
        near = {j: _turning(known[:, j], blurred(corner)) for j, corner in lower.items()}
        while near:
            left = moving & ~out[:, k]
            times = {j: _times(above[lower[j]], left, places) for j, places in near.items()}
            most = max(times, key=lambda j: times[j])
            if times[most] <= _SHAKES:
                break
            place = out[:, k] | near.pop(most)
            if np.count_nonzero(place & moving) <= _MOST * np.count_nonzero(moving):
                out[:, k] = place
    return out


def _above(torque: np.ndarray, corner: float) -> np.ndarray:
    """(N,) the square of what a torque (N,) holds above a corner."""
    return np.square(torque - smooth(torque, corner))


def _turning(known: np.ndarray, blur: int) -> np.ndarray:
    """(N,) the ends of the rests of a joint, of which friction's sign is known (N,) elsewhere, as blurred."""
    near = np.zeros(len(known), bool)
    for end in stretches(~known).ravel().tolist():
        if 0 < end < len(known):
            near[max(end - blur, 0) : end + blur] = True
    return near


def _times(energy: np.ndarray, moving: np.ndarray, near: np.ndarray) -> float:
    """How many times the mean energy elsewhere lies near the reversals; 0 where too little is either."""
    here, elsewhere = moving & near, moving & ~near
    if not here.any() or np.count_nonzero(elsewhere) < _FEWEST * np.count_nonzero(moving):
        return 0.0
    return float(energy[here].mean() / max(energy[elsewhere].mean(), 1e-300))
