"""What is said to be named is named in four of five cases, as far as the gate's own noise goes."""

import numpy as np
import pytest

from pyident.diagnosis.motions.detectable import needed_gain
from pyident.rules.rules import RULES

DRAWS = np.random.default_rng(0).standard_normal(20000)  # the root of a gain in units of the floor


@pytest.mark.parametrize("least", [20.0, 150.0])
def test_no_chance_in_four_of_five(least):
    root = np.sqrt(needed_gain(RULES.search, least, left=0.0, unseen=0.0, ratio=0.0))
    assert np.mean((root + DRAWS) ** 2 >= least) == pytest.approx(0.8, abs=0.01)


def test_the_share_of_what_exceeds_the_floor_in_four_of_five():
    left, needed = 400.0, RULES.search.explained[0]
    gain = (np.sqrt(needed_gain(RULES.search, 20.0, left, unseen=0.0, ratio=0.0)) + DRAWS) ** 2
    assert np.mean(gain / (gain + left) >= needed) == pytest.approx(0.8, abs=0.01)


def test_held_out_logs_show_it_in_four_of_five():
    """They are half as many; their fall has the standard deviation of twice the root of what is taken."""
    root = np.sqrt(needed_gain(RULES.search, 20.0, left=0.0, unseen=0.0, ratio=2.0) / 2)
    fall = root**2 + 2 * root * DRAWS
    assert np.mean(fall >= RULES.search.chance * 2 * root) == pytest.approx(0.8, abs=0.01)


def test_an_excess_of_held_out_logs_asks_for_more():
    calm, other = (needed_gain(RULES.search, 20.0, 50.0, unseen, 2.0) for unseen in (10.0, 1000.0))
    assert other > 3 * calm
