"""Samples in which a torque changes faster than a motion without its noise can follow.

A path of ramps, or of ramps of speed, has a jerk at every corner: the torque bends within a sample or two.
The motion is known only below the corner of its low pass, so that beside a bend the equation holds the torque
with frequencies that the acceleration has lost. This is neither noise nor a law that the model lacks, and
like reversals of friction such samples are left out. A torque that is lost or sticks out for a sample is one
of them.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d

from pyident.conditioning.motion import Motion
from pyident.conditioning.reversals.rest import creeping, without_steps
from pyident.conditioning.smooth_motion import blurred, smooth

_STANDS_OUT = 8.0  # standard deviations of what the torque usually has above the corner
_MATTERS = 0.005  # of the torque's rms
_MOST = 0.2  # of the samples in motion: where more seem to bend that is what this torque does


def bends(torque: np.ndarray, moving: np.ndarray, corner: float) -> np.ndarray:
    """(N,) whether a torque (N,) bends within what the low pass of its joint's motion blurs.

    moving   (N,) whether the joint is away from rest: friction's own steps are no bends
    corner   of the motion, over the Nyquist frequency
    """
    if not moving.any():
        return np.zeros(len(torque), bool)
    above, blur = np.abs(torque - smooth(torque, corner)), blurred(corner)
    usual = 1.4826 * float(np.median(above))
    bent = above > max(_STANDS_OUT * usual, _MATTERS * float(np.sqrt(np.mean(torque**2))))
    bent &= ~_widened(~moving, blur)
    near = _widened(bent, blur)
    return near if near[moving].mean() <= _MOST else np.zeros(len(torque), bool)


def telling(
    known: np.ndarray, torque: np.ndarray, motion: Motion, k: int, corner: float, period: float
) -> np.ndarray:
    """(N,) whether the equation of joint k (from 0) holds in a sample of a motion without its noise.

    known    (N,) where friction's sign is known, as of `away_from_rest`
    torque   (N,) of the joint;  corner: of its motion, over the Nyquist frequency;  period [s]
    """
    moving = without_steps(known, motion.ddq[:, k], blurred(corner))
    moving = moving & ~creeping(motion.q[:, k], motion.dq[:, k], period)
    return moving & ~bends(torque, moving, corner)


def _widened(places: np.ndarray, by: int) -> np.ndarray:
    return maximum_filter1d(places.astype(np.uint8), 2 * by + 1).astype(bool)
