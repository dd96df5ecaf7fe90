"""Multisines: power where it was asked for, and phases that keep the peak low."""

import numpy as np
import pytest

from flexmodels.multisine import crest_factor, flattened, wave

F = np.linspace(1.0, 20.0, 39)  # multiples of half a hertz: periodic in two seconds
T = np.arange(2000) / 1000


def test_unit_rms_and_no_other_frequency():
    x = wave(T, F, np.random.default_rng(0).uniform(0, 6, len(F)))
    assert np.sqrt(np.mean(x**2)) == pytest.approx(1.0)
    power = np.abs(np.fft.rfft(x)) ** 2
    lines = np.round(F * 2).astype(int)
    assert power[lines].sum() / power.sum() == pytest.approx(1.0)
    assert np.ptp(power[lines]) < 1e-9 * power.max()


def test_phases_are_flattened_below_schroeders():
    """Schroeder's phases have a crest factor of about 1.7; clipping gets below."""
    n = np.arange(len(F))
    schroeder = crest_factor(wave(T, F, -np.pi * n * (n + 1) / len(F)))
    start = np.random.default_rng(1).uniform(0, 2 * np.pi, len(F))
    found = crest_factor(wave(T, F, flattened(start, F)))
    assert found < min(1.7, schroeder)
    assert crest_factor(wave(T, F, start)) > 2.2


def test_the_crest_factor_of_a_sine():
    assert crest_factor(np.sin(2 * np.pi * T)) == pytest.approx(np.sqrt(2), rel=1e-4)
