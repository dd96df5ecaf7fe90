"""Where a model is said to fail."""

from dataclasses import replace

import pytest

from pyident.comparison.bins import Bin
from pyident.comparison.fails import Fails

THIRD = Bin("joint3.e", "motor", "speed", "above 1 rad/s", 1.0, 2.0, "rad/s", 2.6, 9.0, 0.5, 0.3)


@pytest.mark.parametrize(
    ("values", "structure", "where", "structural"),
    [
        (None, None, None, False),
        (2.6, None, "joint2.e", False),
        (None, 2.6, "joint3.e", True),
        (13.0, 2.6, "joint2.e", False),
        (2.0, 2.6, "joint3.e", True),
    ],
)
def test_values_that_are_far_off_elsewhere_come_before_what_no_values_mend(
    values, structure, where, structural
):
    off = None if values is None else replace(THIRD, coordinate="joint2.e", ratio=values)
    left = None if structure is None else replace(THIRD, ratio=structure)
    fails = Fails(off, left)
    assert (fails.where and fails.where.coordinate, fails.structural) == (where, structural)
    said = fails.sentence(True)
    assert ("joint 3" in said) == (structure is not None)
    assert ("identify it on these logs" in said) == (where is not None and not structural)


def test_of_one_equation_what_no_values_mend_is_said():
    assert Fails(replace(THIRD, ratio=13.0), THIRD).structural
