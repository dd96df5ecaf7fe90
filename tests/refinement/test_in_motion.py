"""What a fit leaves where torques move, whatever noise there is above."""

import numpy as np
import pytest

from pyident.refinement.in_motion import Rest

PERIOD, TIME = 0.002, np.arange(5000) * 0.002
TORQUES = np.column_stack([20 * np.sin(2 * np.pi * TIME), 2 * np.cos(4 * np.pi * TIME)])
NOISE = np.random.default_rng(1).normal(0, 1.0, TORQUES.shape)


def left(slow: float, noise: float) -> float:
    return Rest([slow * TORQUES + noise * NOISE], [TORQUES], [PERIOD]).in_motion


def test_it_is_the_share_that_moves_with_the_torques():
    assert left(0.1, 0.0) == pytest.approx(0.1**2, rel=0.05)


def test_noise_above_the_motion_hardly_counts():
    """Splines that move positions raise it, while what was missing in the motion is gone."""
    assert left(0.01, 0.1) < 0.2 * left(0.05, 0.05)


def test_where_nothing_moves_nothing_is_left():
    still = Rest([np.ones_like(TORQUES)], [np.zeros_like(TORQUES)], [PERIOD])
    assert still.in_motion == 0.0
