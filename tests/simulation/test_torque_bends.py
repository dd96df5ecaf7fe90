"""Where a torque bends faster than the motion can be told."""

import numpy as np

from pyident.conditioning.reversals.torque_bends import bends
from pyident.conditioning.smooth_motion import blurred

PERIOD, CORNER = 0.008, 0.12  # s; over the Nyquist frequency
TIME = np.arange(0, 20, PERIOD)
MOVING = np.ones(len(TIME), bool)
NOISE = 0.05 * np.random.default_rng(5).standard_normal(len(TIME))


def test_the_corners_of_a_path_of_ramps_are_found_and_nothing_else():
    torque = 10 * np.sin(TIME) + 20 * ((TIME > 5) & (TIME < 12)) + NOISE
    found = np.flatnonzero(bends(torque, MOVING, CORNER)) * PERIOD
    reach = 2.2 * blurred(CORNER) * PERIOD
    apart = np.minimum(abs(found - 5), abs(found - 12))
    assert apart.max() < reach
    assert {5, 12} <= {round(t) for t in found}


def test_a_smooth_torque_with_noise_has_none():
    assert not bends(10 * np.sin(3 * TIME) + NOISE, MOVING, CORNER).any()


def test_a_reversal_of_friction_is_no_bend():
    torque = 4 * np.sign(np.cos(TIME)) + NOISE
    moving = np.abs(np.cos(TIME)) > 0.02
    assert not bends(torque, moving, CORNER).any()
    assert bends(torque, MOVING, CORNER).any()


def test_a_sample_that_sticks_out_is_one():
    torque = 10 * np.sin(TIME) + NOISE
    torque[1234] = 0
    assert bends(torque, MOVING, CORNER)[1234]


def test_where_a_torque_bends_all_the_time_none_is_left_out():
    torque = 10 * np.sin(TIME) + 5 * (np.arange(len(TIME)) % 100 == 0)
    assert not bends(torque, MOVING, CORNER).any()


def test_a_joint_that_moves_for_a_while_only_keeps_that_while():
    """Standing, its torque is quiet. Where in motion it is not, that is no bend."""
    moving = (TIME > 4) & (TIME < 8)
    alone = 10 * np.sin(TIME) + NOISE + moving * np.sin(2 * np.pi * 30 * TIME)
    assert not bends(alone, moving, CORNER).any()
    stepped = 10 * np.sin(TIME) + NOISE + 20 * (TIME > 6)
    left_out = bends(stepped, moving, CORNER) & moving
    assert left_out[np.searchsorted(TIME, 6)]
    assert left_out.sum() < 0.2 * moving.sum()
