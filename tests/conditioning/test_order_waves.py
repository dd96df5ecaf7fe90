"""Waves over an angle that were put into noise: they are found, and taken out with little else."""

from dataclasses import replace

import numpy as np
import pytest
from one_joint import one_joint

from pyident.conditioning.order_waves import (
    highest_of,
    orders_within,
    peaks_at_speeds,
    peaks_of,
    without_waves,
)
from pyident.rules.rules import RULES

PERIOD, SIGMA = 0.004, 0.1
TIME = np.arange(8000) * PERIOD
ANGLE = 1.1 * np.sin(0.9 * TIME) + 0.4 * np.sin(2.3 * TIME)
SPEED = np.gradient(ANGLE, TIME)
MOVING = np.abs(SPEED) > 0.05
ORDERS = orders_within([ANGLE], np.abs(SPEED), PERIOD, RULES.periodic.highest, RULES.periodic)


def noise(seed: int) -> np.ndarray:
    return SIGMA * np.random.default_rng(seed).standard_normal(len(TIME))


def left_of(x: np.ndarray) -> float:
    """Standard deviation of what is known of x (N,) once waves are taken out."""
    return float(without_waves(x, ANGLE, SPEED, MOVING, ORDERS, RULES.periodic)[MOVING].std())


@pytest.mark.parametrize("turning", [1.0, np.sign(SPEED)])
@pytest.mark.parametrize("order", [23.7, 101.3])
def test_a_wave_eight_times_the_noise_is_taken_out(order, turning):
    x = noise(1) + 8 * SIGMA * np.sqrt(2) * turning * np.cos(order * ANGLE + 0.4)
    assert x[MOVING].std() > 7 * SIGMA
    assert left_of(x) == pytest.approx(SIGMA, rel=0.05)


def test_noise_keeps_its_size():
    assert np.mean([left_of(noise(seed)) for seed in range(10)]) == pytest.approx(SIGMA, rel=0.01)


def test_what_is_not_known_is_left_alone():
    x = noise(2) + np.cos(50 * ANGLE)
    made = without_waves(x, ANGLE, SPEED, MOVING, ORDERS, RULES.periodic)
    np.testing.assert_array_equal(made[~MOVING], x[~MOVING])


def test_a_screw_of_four_millimetres_is_within_the_orders_of_a_slider():
    """A period of 4 mm is an order of 2 pi / 0.004 per 2 pi metres."""
    hinge = one_joint().joints[0]
    slider = replace(hinge, kind="prismatic")
    order, travel = 2 * np.pi / 0.004, 0.1 * ANGLE
    speeds = 0.1 * np.abs(SPEED)
    orders = orders_within([travel], speeds, PERIOD, highest_of(slider, RULES.periodic), RULES.periodic)
    (found,) = peaks_of([noise(3) + SIGMA * np.cos(order * travel)], [travel], orders, RULES.periodic)
    assert found == pytest.approx(order, abs=orders[1] - orders[0])
    assert highest_of(hinge, RULES.periodic) == RULES.periodic.highest < order


def answered(order: float) -> np.ndarray:
    """What an oscillator of 8 Hz makes of a wave: large at one speed, its phase turned round there."""
    speed = order * SPEED / (2 * np.pi * 8.0)
    gain = 1 / (1 - speed**2 + 0.2j * speed)
    return SIGMA * np.real(gain * np.exp(1j * order * ANGLE))


@pytest.mark.parametrize("order", [33.4, 57.0])
def test_a_wave_whose_phase_turns_with_the_speed_is_found_part_by_part(order):
    x = noise(3) + answered(order)
    found = peaks_at_speeds([x], [ANGLE], [SPEED], ORDERS, RULES.periodic)
    assert min(abs(n - order) for n in found) < 1.5


def test_noise_has_no_wave_at_any_speed():
    for seed in range(10):
        assert peaks_at_speeds([noise(seed)], [ANGLE], [SPEED], ORDERS, RULES.periodic) == []


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_wave_that_fills_its_neighbours_as_an_axis_dwells_stands_out(seed):
    """From place to place, at rest two thirds of the time: each place is a sum of all orders."""
    rng, time = np.random.default_rng(seed), np.arange(0, 40, 0.01)
    places = rng.uniform(-1.9, 1.9, 9)
    way, number = np.clip((time % 4.5) / 1.5, 0, 1), (time // 4.5).astype(int) % 8
    angle = places[number] + (places[number + 1] - places[number]) * way**3 * (10 - 15 * way + 6 * way**2)
    speeds = np.abs(np.gradient(angle, time))
    orders = orders_within([angle], speeds, 0.01, RULES.periodic.highest, RULES.periodic)
    hiss = rng.normal(0, 2, len(time))
    x = 25 * np.cos(36 * angle + 0.4) + hiss
    assert peaks_of([x - x.mean()], [angle], orders, RULES.periodic) == pytest.approx([36.0], abs=0.5)
    assert peaks_of([hiss], [angle], orders, RULES.periodic) == []
