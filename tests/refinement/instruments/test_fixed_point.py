"""Steps to a fixed point against the closed form of a linear map, and on one that is not linear."""

import numpy as np
import pytest

from pyident.refinement.instruments.fixed_point import FixedPoint

RNG = np.random.default_rng(4)
SLOPE = 0.6 * np.linalg.qr(RNG.standard_normal((6, 6)))[0]
OFFSET = RNG.standard_normal(6)


def linear(p):
    return SLOPE @ p + OFFSET


def gaps(g, steps, p, rounds):
    sizes = []
    for _ in range(rounds):
        sizes.append(float(np.abs(g(p) - p).max()))
        p = p + steps.step(g(p) - p)
    return p, sizes


def test_with_the_true_slope_one_step_arrives():
    p, _ = gaps(linear, FixedPoint(np.eye(6) - SLOPE, np.ones(6)), np.zeros(6), 1)
    assert p == pytest.approx(np.linalg.solve(np.eye(6) - SLOPE, OFFSET), rel=1e-12)


def test_without_a_slope_it_arrives_after_at_most_two_rounds_per_parameter():
    p, _ = gaps(linear, FixedPoint(np.eye(6), np.ones(6)), np.zeros(6), 13)
    assert p == pytest.approx(np.linalg.solve(np.eye(6) - SLOPE, OFFSET), rel=1e-8)


def test_corrections_make_up_for_a_slope_that_changes():
    def bent(p):
        return 0.8 * np.cos(p)  # a fixed point at 0.62, slope there -0.46

    p, sizes = gaps(bent, FixedPoint(np.eye(1), np.ones(1)), np.array([2.0]), 9)
    assert p[0] == pytest.approx(0.8 * np.cos(p[0]), rel=1e-10)
    assert sizes[5] < 1e-4 * sizes[0]


def test_a_parameter_that_does_not_count_stays_out_of_the_corrections():
    steps, alone = FixedPoint(np.eye(2), np.array([1.0, np.inf])), FixedPoint(np.eye(1), np.ones(1))
    for gap in (1.0, 0.5, 0.1):
        assert steps.step(np.array([gap, 5.0]))[0] == pytest.approx(alone.step(np.array([gap]))[0], rel=1e-12)


def test_what_sticks_near_the_fixed_point_sends_no_step_far_away():
    def sticking(p):
        return 0.5 * p + 0.1 * np.sign(p) + 1e-4 * np.round(20 * p)  # falls to zero, and jumps across it

    steps, p = FixedPoint(np.eye(1) * 0.5, np.ones(1)), np.array([1.0])
    seen = []
    for _ in range(30):
        p = p + steps.step(sticking(p) - p)
        seen.append(abs(float(p[0])))
    alike = FixedPoint(np.eye(1), np.ones(1))
    alike.step(np.array([0.1]))
    assert alike.step(np.array([0.0999])) == pytest.approx(0.0999)  # a secant's step would be 99.9
    assert max(seen) < 1.0
