"""A low pass on motions known in closed form, with white noise: only the noise below the corner is left."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from pyident.conditioning.smooth_motion import smooth

NOISE = 1e-6


def moved(samples: int, turns: float = 20.0) -> np.ndarray:
    """A motion that ends neither at rest nor where it began."""
    t = np.linspace(0, turns, samples)
    return np.sin(t + 1) + 0.3 * np.cos(2.3 * t)


LONG = [(60_000, 0.05), (60_000, 0.18), (200_000, 0.02)]


@pytest.mark.parametrize(("samples", "corner"), [(2500, 0.3), (5000, 0.02), (6001, 0.1), *LONG])
def test_only_noise_below_the_corner_is_left(samples, corner):
    """In logs of any length, those whose transforms are slow (a prime of 4999 intervals) among them."""
    true, inner = moved(samples), slice(samples // 50, -samples // 50)
    noise = NOISE * np.random.default_rng(0).standard_normal(samples)
    left = smooth(true + noise, corner) - true
    assert left[inner].std() == pytest.approx(NOISE * np.sqrt(1.6 * corner), rel=0.15)
    bent, of_noise = (np.diff(x, 2)[inner].std() for x in (left, noise))
    w = np.pi * corner * np.linspace(0, 2.5, 1000)
    # of the passed noise, differenced twice: the gain falls from 1 to 2.5 corners
    gain = np.cos(np.pi / 2 * np.clip((w / (np.pi * corner) - 1) / 1.5, 0, 1)) ** 2
    passed = np.sqrt(trapezoid((gain * (2 - 2 * np.cos(w))) ** 2, w) / np.pi / 6)
    assert bent / of_noise == pytest.approx(passed, rel=0.25)


def test_a_motion_without_noise_stays_as_it_is_up_to_its_ends():
    true = moved(5000)
    assert smooth(true, 0.05) == pytest.approx(true, abs=1e-8)
