"""Where a residual leaves its ribbon: stretches with known edges."""

from dataclasses import replace

import numpy as np
import pytest

from pyident.comparison.traces import Trace, _ribbon, bumps, low_passed

RATE = 500.0
TIME = np.arange(5000) / RATE


def trace(envelope: np.ndarray) -> Trace:
    """A fast wave under an envelope [N m] beside a ribbon of 0.1 N m on either side."""
    wave = envelope * np.sqrt(2) * np.sin(2 * np.pi * 40 * TIME)
    edge = np.full(len(TIME), 0.1)
    return Trace(
        "log", "joint1.e", TIME, TIME, TIME, None, wave, 0 * TIME, wave, -edge, edge, TIME >= 0, 50.0
    )


def hump(middle: float, width: float) -> np.ndarray:
    return np.exp(-(((TIME - middle) / width) ** 2))


def test_inside_the_ribbon_there_is_none():
    assert bumps(trace(np.full(len(TIME), 0.09))) == []


def test_a_block_has_its_edges_and_its_ratio():
    """Edges to within the window of a quarter of a second; the larger of two blocks first."""
    small = np.where((TIME > 2) & (TIME < 3), 0.5, 0.0)
    large = np.where((TIME > 6) & (TIME < 8), 1.0, 0.0)
    first, second = bumps(trace(small + large))
    assert (first.start, first.stop) == pytest.approx((6, 8), abs=0.13)
    assert (second.start, second.stop) == pytest.approx((2, 3), abs=0.13)
    assert first.over_floor == pytest.approx(10, rel=0.02)
    assert first.share + second.share == pytest.approx(1, abs=0.02)
    assert second.share == pytest.approx(0.24 / (0.24 + 2 * 0.99), rel=0.05)


def test_humps_above_the_ribbon_are_parted_at_their_valley():
    listed = bumps(trace(0.3 + hump(3, 0.8) + hump(6, 0.8)))
    assert len(listed) == 2
    assert sorted(b.start for b in listed)[1] == pytest.approx(4.5, abs=0.2)


def test_a_dent_does_not_part_a_bump():
    assert len(bumps(trace(0.3 + hump(4, 0.8) + hump(5, 0.8)))) == 1


@pytest.mark.parametrize("cutoff", [5.0, 20.0, 80.0])
def test_the_ribbon_holds_nine_tenths_of_what_replicas_are(cutoff):
    """Seven draws of the same noise, one of them taken for the data: 5 to 95 % is 90 %."""
    rng = np.random.default_rng(3)
    inside = []
    for _ in range(10):
        noise = [low_passed(rng.standard_normal(len(TIME)), 1 / RATE, cutoff) for _ in range(7)]
        low, high = _ribbon(noise[1:], len(TIME), 1 / RATE)
        inside.append(np.mean((noise[0] > low) & (noise[0] < high)))
    assert np.mean(inside) == pytest.approx(0.9, abs=0.05)


def test_what_all_replicas_share_lies_inside_the_ribbon():
    rng = np.random.default_rng(4)
    trend = np.sin(2 * np.pi * 0.2 * TIME)
    low, high = _ribbon(
        [trend + 0.01 * rng.standard_normal(len(TIME)) for _ in range(6)], len(TIME), 1 / RATE
    )
    assert np.mean((trend > low) & (trend < high)) > 0.95
    assert np.mean(high - low) == pytest.approx(2 * 1.645 * 0.01, rel=0.05)


@pytest.mark.parametrize(("cutoff", "most"), [(5.0, 0.5), (20.0, 0.5), (80.0, 0.2)])
def test_noise_leaves_its_ribbon_seldom(cutoff, most):
    """Mean number of bumps in 10 s of noise; each is a place to look at, not a verdict."""
    rng = np.random.default_rng(6)
    counts = []
    for _ in range(40):
        noise = [low_passed(rng.standard_normal(len(TIME)), 1 / RATE, cutoff) for _ in range(7)]
        low, high = _ribbon(noise[1:], len(TIME), 1 / RATE)
        made = trace(np.zeros(len(TIME)))
        counts.append(len(bumps(replace(made, residual=noise[0], low=low, high=high))))
    assert np.mean(counts) < most
