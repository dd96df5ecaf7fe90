"""Samples in which a joint's equation holds what another joint does as it turns round."""

import numpy as np

from pyident.conditioning.reversals.other_reversals import shaken
from pyident.conditioning.reversals.rest import stretches
from pyident.conditioning.smooth_motion import blurred

PERIOD, CORNERS = 0.008, (0.2, 0.1, 0.3)  # s; over the Nyquist frequency
TIME = np.arange(0, 30, PERIOD)
RATES = (0.31, 0.47, 0.23)  # Hz
SPEEDS = np.column_stack([np.cos(2 * np.pi * rate * TIME) for rate in RATES])
KNOWN = np.abs(SPEEDS) > 0.02


def torques(*bursts: tuple[int, int]) -> np.ndarray:
    """(N, 3), smooth, with noise, and bursts in the torque of one joint where another turns round."""
    rng = np.random.default_rng(4)
    out = 10 * SPEEDS + 0.05 * rng.standard_normal(SPEEDS.shape)
    for joint, other in bursts:
        turns = np.flatnonzero(np.diff(np.sign(SPEEDS[:, other])))
        out[turns, joint] += 0.6
        out[turns + 1, joint] -= 0.6
    return out


def test_reversals_that_shake_another_joint_are_left_out_of_its_equation_alone():
    out = shaken(KNOWN, KNOWN, torques((0, 1)), CORNERS)
    assert not out[:, 1:].any()
    turns = np.flatnonzero(np.diff(np.sign(SPEEDS[:, 1])))
    assert out[turns, 0].all()
    reach = blurred(CORNERS[1]) + np.diff(stretches(~KNOWN[:, 1])).max()
    distance = np.abs(np.subtract.outer(np.flatnonzero(out[:, 0]), turns)).min(axis=1)
    assert distance.max() <= reach


def test_reversals_that_shake_nothing_are_not():
    assert not shaken(KNOWN, KNOWN, torques(), CORNERS).any()


def test_two_that_shake_are_both_left_out():
    out = shaken(KNOWN, KNOWN, torques((2, 0), (2, 1)), CORNERS)
    for other in (0, 1):
        assert out[np.flatnonzero(np.diff(np.sign(SPEEDS[:, other]))), 2].all()


def test_no_more_is_left_out_than_a_motion_can_spare():
    """One that turns round all the time is another machine's shaking, or leaves nothing to compare with."""
    known = KNOWN.copy()
    known[::9, 1] = False
    noisy = torques()
    noisy[::9, 0] += 1.0
    assert not shaken(known, known, noisy, CORNERS)[:, 0].any()
