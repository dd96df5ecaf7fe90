"""What counts as standing still."""

import numpy as np
import pytest

from pyident.rules.stillness import stands_still

ROUNDING = 1e-16 * np.random.default_rng(0).standard_normal(100)


@pytest.mark.parametrize("at", [0.0, 0.5, -3e4])
def test_one_value_stands_still_wherever_it_is(at):
    assert stands_still(np.full(100, at))
    assert stands_still(at * (1 + ROUNDING))


def test_a_step_of_a_fine_encoder_is_motion():
    """One count of 26 bits in a turn."""
    x = np.full(100, 3.0)
    x[50:] += 2 * np.pi / 2**26
    assert not stands_still(x)


def test_recordings_at_different_places_are_no_standstill():
    assert not stands_still(np.zeros(9), np.ones(9))


def test_rounding_about_zero_is_measured_by_what_is_beside_it():
    assert not stands_still(ROUNDING)
    assert stands_still(ROUNDING, beside=1.0)
