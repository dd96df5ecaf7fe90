"""Equations in the frequency domain: energies by Parseval, levels of known noise."""

import numpy as np
import pytest
from analytic_joint import analytic_log, free_joint

from pyident.conditioning.weak_form import condition
from pyident.regression.spectrum import Band, Floor, equations, floor, floors, pooled


def test_the_transform_is_unitary():
    """All bins of a real signal hold its energy; the first and the last count half."""
    x = np.random.default_rng(0).standard_normal(512)
    band = Band(512, 257, 0.01)
    S = band.transform(x)
    inner = np.r_[1:256]
    energy = np.square(S[inner]).sum() + np.square(S[257 + inner]).sum()
    ends = (np.square(S[[0, 256]]).sum()) / 2
    assert energy + ends == pytest.approx(np.square(x).sum())
    assert band.frequencies[-1] == pytest.approx(50.0)


def test_white_noise_keeps_its_variance():
    x = 3.0 * np.random.default_rng(1).standard_normal((4000, 8))
    S = Band(4000, 2000, 0.01).transform(x)
    assert np.std(S) == pytest.approx(3.0, rel=0.02)


def test_a_floor_is_the_rms_of_its_replicas():
    """Noise with a level that grows with frequency, from replicas of two lengths."""
    rng = np.random.default_rng(2)
    bands = [Band(1000, 400, 0.01), Band(600, 240, 0.01)] * 30
    level = [1 + band.frequencies / 10 for band in bands]
    residuals = [np.tile(at, 2) * rng.standard_normal((1, 2 * len(at))) for at in level]
    found = floor(bands, residuals)
    inside = (found.frequencies > 2) & (found.frequencies < 36)
    ratio = found.rms[0, inside] / (1 + found.frequencies[inside] / 10)
    assert ratio == pytest.approx(np.ones(inside.sum()), abs=0.12)


def test_a_floor_is_read_between_its_frequencies():
    level = Floor(np.array([0.0, 10.0]), np.array([[1.0, 3.0]])).at(Band(100, 3, 0.1))
    assert level == pytest.approx(np.tile(1 + 2 * np.array([0.0, 0.1, 0.2]) / 10, (1, 2)).reshape(1, -1))


def test_the_equations_hold_for_the_true_parameters():
    robot = free_joint()
    part = condition(analytic_log(), robot)
    whole = equations(robot, [part], [0.004])[0]
    p = np.array(list(robot.linear_parameters.values()))
    left = np.linalg.norm(whole.y - whole.A @ p) / np.linalg.norm(whole.y)
    assert left < 1e-6
    halved = whole.over(np.full_like(whole.y, 2.0))
    np.testing.assert_allclose(halved.A, whole.A / 2)
    np.testing.assert_allclose(halved.y, whole.y / 2)


def test_every_log_has_a_floor_of_its_own_and_another_their_mean_power():
    """Two replicas of a quiet and a loud log, in turn."""
    bands = [Band(400, 100, 0.01)] * 4
    rng = np.random.default_rng(0)
    residuals = [size * rng.standard_normal((1, 200)) for size in (1.0, 3.0, 1.0, 3.0)]
    quiet, loud = floors(bands, residuals, 2)
    assert np.sqrt(np.mean(quiet.rms**2)) == pytest.approx(1.0, rel=0.1)
    assert np.sqrt(np.mean(loud.rms**2)) == pytest.approx(3.0, rel=0.1)
    assert np.sqrt(np.mean(pooled([quiet, loud]).rms ** 2)) == pytest.approx(np.sqrt(5), rel=0.1)
