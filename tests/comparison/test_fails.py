"""Where a model is said to fail."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pyident.comparison.bins import Bin
from pyident.comparison.fails import Fails
from pyident.comparison.model_against_replicas import Part
from pyident.comparison.slow_noise import with_slow_noise

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


def test_what_slow_noise_may_do_as_well_is_not_said_to_fail():
    fails = Fails(None, THIRD)
    doubted = fails.beside(Fails(None, None))
    assert doubted.where is None
    assert not doubted.structural
    assert "most is left at joint 3, motor side, above 1 rad/s: 2.6 times the floor" in doubted.sentence(True)
    assert fails.beside(Fails(None, THIRD)) is fails
    off = replace(THIRD, ratio=9.0)
    assert fails.beside(Fails(off, None)).where == off


def test_beside_slow_noise_values_that_are_off_say_by_how_much_beyond_it():
    off = replace(THIRD, ratio=9.0)
    told = Fails(off, off).beside(Fails(replace(off, ratio=3.0), None)).sentence(True)
    assert "9 times the floor (3 times that of slow noise, if these logs have any)" in told
    assert "only make up for what is missing" in told
    assert "slow noise" not in Fails(off, None).beside(Fails(off, None)).sentence(True)


def test_slow_noise_rises_in_replicas_below_what_was_measured_and_on_motor_sides_alone():
    """As 1/f² in energy for two octaves: at a quarter of the frequency four times the amplitude."""
    time, period = np.arange(4000) * 0.01, 0.01
    waves = {f: np.cos(2 * np.pi * f * time) for f in (0.5, 2.0, 8.0)}
    left = np.column_stack([sum(waves.values()), sum(waves.values())])
    use = SimpleNamespace(use=np.ones((4000, 2)))
    part = Part(cast(Any, use), period, left, left, time, {}, np.zeros((4000, 1)))
    log = object()
    sensors = SimpleNamespace(torques={"joint1.tau": SimpleNamespace(continued=2.0)})
    trial = SimpleNamespace(
        repeats=[SimpleNamespace(log=log, sensors=sensors)],
        paths=[],
        judged=[SimpleNamespace(log=log)],
        robot=SimpleNamespace(torques=["joint1.tau"], joints=[None]),
    )
    ((raised,),) = with_slow_noise(cast(Any, trial), [[part]])
    np.testing.assert_allclose(raised.residual[:, 1], left[:, 1])
    np.testing.assert_allclose(raised.refitted[:, 0], 4 * waves[0.5] + waves[2.0] + waves[8.0], atol=1e-9)
