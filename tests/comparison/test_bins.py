"""Bins of a residual whose excess was put where it is: in a band, or on one side of a reversal."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import analytic_log, free_joint
from scipy.signal import butter, sosfiltfilt

from pyident.comparison.bins import breakdown, mean_square_over_floor
from pyident.comparison.model_against_replicas import Part, loads_of
from pyident.conditioning.weak_form import condition

PERIOD = 0.004


@pytest.fixture(scope="module")
def conditioned():
    robot = free_joint()
    return robot, condition(analytic_log(seconds=40.0), robot)


def _part(conditioned, seed, excess=None):
    part = conditioned[1]
    rng = np.random.default_rng(seed)
    residual = rng.standard_normal(part.target.shape)
    if excess is not None:
        residual = residual + excess(part, rng)[:, None]
    residual = residual * part.use
    return Part(part, PERIOD, residual, residual, np.zeros(0), {}, loads_of(conditioned[0], part))


def _bins(conditioned, excess):
    replicas = [[_part(conditioned, seed)] for seed in range(1, 13)]
    data = [_part(conditioned, 0, excess)]
    found = breakdown(conditioned[0], data, replicas, ["log"], refitted=False)
    return {kind: [b for b in found if b.kind == kind] for kind in {b.kind for b in found}}


def _in_band(part, rng):
    """White noise of eight times the floor's density between 4 and 8 Hz."""
    sos = butter(6, [4.0 * 2 * PERIOD, 8.0 * 2 * PERIOD], "band", output="sos")
    return 8 * sosfiltfilt(sos, rng.standard_normal(len(part.target)))


def test_at_the_floor_nothing_stands_out(conditioned):
    for kind, bins in _bins(conditioned, None).items():
        for b in bins:
            assert b.ratio == pytest.approx(1.0, abs=0.35), (kind, b.label)
            assert abs(b.deviations) < 5, (kind, b.label)


def test_an_excess_in_a_band_is_found_in_it(conditioned):
    bands = {(b.low, b.high): b for b in _bins(conditioned, _in_band)["frequency"]}
    inside = bands[4.0, 8.0]
    assert inside.ratio == pytest.approx(np.sqrt(1 + 8**2), rel=0.25)
    assert inside.share > 0.85
    assert bands[16.0, 32.0].ratio == pytest.approx(1.0, abs=0.15)
    assert sum(b.share for b in bands.values()) == pytest.approx(1.0)
    assert sum(b.data_share for b in bands.values()) == pytest.approx(1.0)


def test_an_excess_of_one_direction_is_found_there(conditioned):
    def forward(part, rng):
        return _in_band(part, rng) * (part.motion.dq[:, 0] > 0)

    back, forth = sorted(_bins(conditioned, forward)["direction"], key=lambda b: b.low)
    assert forth.label == "moving forward"
    assert forth.ratio > 3 * back.ratio
    assert forth.share > 0.8


def test_mean_square(conditioned):
    replicas = [[_part(conditioned, seed)] for seed in range(1, 13)]
    alike = mean_square_over_floor([_part(conditioned, 50)], replicas, [0])
    assert alike == pytest.approx(1.0, abs=0.1)
    louder = _part(conditioned, 50)
    louder = replace(louder, residual=3 * louder.residual)
    assert mean_square_over_floor([louder], replicas, [0]) == pytest.approx(9 * alike)
