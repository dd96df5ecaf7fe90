"""Spectra of a torque's noise against those that it was made with."""

import numpy as np
import pytest
from scipy.signal import bessel, butter, sosfilt, sosfreqz

from pyident.simulation.noise.noise_spectrum import (
    NoiseSpectrum,
    between_reversals,
    bridged,
    repeated_spectrum,
)
from pyident.simulation.noise.repetition import period_of, repetition_of

PERIOD, POLE = 0.01, 0.9
SLOW = np.array([0.1, 0.3])  # Hz, where the motion is


def noise(count: int, seed: int, coloured: float = 1.0, white: float = 0.5) -> np.ndarray:
    """White noise beside an autoregression of first order, (count,)."""
    rng = np.random.default_rng(seed)
    steps, x = rng.standard_normal(count), np.zeros(count)
    for i in range(1, count):
        x[i] = POLE * x[i - 1] + np.sqrt(1 - POLE**2) * steps[i]
    return coloured * x + white * rng.standard_normal(count)


def true(f: np.ndarray, coloured: float = 1.0, white: float = 0.5) -> np.ndarray:
    """Its density, in closed form."""
    low_passed = (1 - POLE**2) / np.abs(1 - POLE * np.exp(-2j * np.pi * f * PERIOD)) ** 2
    return 2 * PERIOD * (coloured**2 * low_passed + white**2)


def course(time: np.ndarray) -> np.ndarray:
    """Joint angles that come back after 7.77 s, which is no whole number of samples."""
    turns = 2 * np.pi * time / 7.7734
    return np.column_stack([np.sin(turns) + 0.3 * np.cos(3 * turns), np.cos(2 * turns)])


def mean_of(found: list[NoiseSpectrum], f: np.ndarray) -> np.ndarray:
    return np.mean([np.interp(f, s.frequencies, s.density) for s in found], axis=0)


def test_the_period_of_a_motion_is_found_between_samples():
    q = course(np.arange(6000) * PERIOD)
    assert period_of(q, np.zeros(2)) == pytest.approx(777.34, abs=0.02)
    rounded = np.round(q / 1e-3) * 1e-3
    assert period_of(rounded, np.full(2, 1e-3 / np.sqrt(12))) == pytest.approx(777.34, abs=0.1)


def test_a_motion_that_does_not_come_back_has_none():
    time = np.arange(6000) * PERIOD
    q = np.sin(2 * np.pi * np.outer(time, [0.31, 0.17]) * (1 + 0.004 * time[:, None]))
    assert period_of(q, np.zeros(2)) is None
    assert period_of(course(time)[:2000], np.zeros(2)) is None  # it comes back twice
    assert period_of(np.zeros((6000, 2)), np.zeros(2)) is None


def test_what_repeats_and_what_drifts_is_no_noise():
    """A law that the model lacks leaves ten times the noise, and falls in the course of the log."""
    time = np.arange(6000) * PERIOD
    angle = course(time)[:, 0]
    law = 10 * np.tanh(np.gradient(angle, PERIOD) / 0.2) * angle**2 * (1 - 0.2 * time / time[-1])
    found = [repeated_spectrum(law + noise(6000, seed), 777.34, PERIOD) for seed in range(8)]
    f = np.array([*SLOW, 3.0, 40.0])
    assert mean_of(found, f) == pytest.approx(true(f), rel=0.25)


def test_between_reversals_a_spectrum_goes_on_below_what_stretches_resolve():
    """A law that is smooth there adds nothing; the noise's corner is at 1.7 Hz."""
    time = np.arange(12000) * PERIOD
    moving = np.abs(np.sin(2 * np.pi * 0.23 * time)) > 0.05
    law = 30 * np.sin(2 * np.pi * 0.23 * time)
    found = []
    for seed in range(8):
        spectrum = between_reversals(law + noise(12000, seed), moving, PERIOD)
        assert spectrum is not None
        found.append(spectrum)
    f = np.array([*SLOW, 3.0, 40.0])
    assert mean_of(found, f) == pytest.approx(true(f), rel=0.3)
    assert between_reversals(law, moving & (np.arange(12000) % 20 > 0), PERIOD) is None


def tones(count: int, seed: int) -> np.ndarray:
    """One for each count of an encoder: at any time a single frequency between 10 and 40 Hz."""
    turns = 2 * np.pi * 0.23 * np.arange(count) * PERIOD + seed
    rate = 25 + 15 * np.sin(turns)
    return np.sqrt(2) * np.sin(2 * np.pi * np.cumsum(rate) * PERIOD)


def power(spectrum: NoiseSpectrum | None, low: float, high: float) -> float:
    assert spectrum is not None
    f = np.linspace(low, high, 1000)
    return float(np.interp(f, spectrum.frequencies, spectrum.density).mean() * (high - low))


def test_above_the_motion_a_tone_counts_that_few_stretches_hold():
    known, values = np.ones(12000, bool), tones(12000, 0)
    whole = between_reversals(values, known, PERIOD, above=5.0)
    assert power(whole, 10, 40) == pytest.approx(1.0, rel=0.15)
    median = between_reversals(values, known, PERIOD)
    assert power(median, 10, 40) < 0.85 * power(whole, 10, 40)


def test_a_spectrum_is_raised_above_a_frequency_alone():
    f = np.array([1.0, 10.0, 20.0])
    low, high = NoiseSpectrum(f, np.array([1.0, 1.0, 3.0]), PERIOD), NoiseSpectrum(f, np.full(3, 2.0), PERIOD)
    assert low.raised(high, 5.0).density.tolist() == [1.0, 2.0, 3.0]


def between(values: np.ndarray, seed: int, period: float) -> NoiseSpectrum:
    """Of noise (N,) under a law of 0.4 Hz that begins anywhere."""
    turns = 2 * np.pi * 0.4 * np.arange(len(values)) * period + np.random.default_rng([seed, 1]).uniform(0, 7)
    found = between_reversals(values + 30 * np.sin(turns), np.abs(np.sin(turns)) > 0.05, period)
    assert found is not None
    return found


@pytest.mark.parametrize(("count", "period"), [(2000, 0.004), (800, 0.01), (12000, 0.01)])  # 8, 8, 120 s
@pytest.mark.parametrize("step", [0.0, 3.0])
def test_white_and_rounded_noise_is_read_as_white(count, period, step):
    """A step of three deviations makes it white noise of 1 + step²/12, by Bennett's rule."""
    found = []
    for seed in range(30):
        white = np.random.default_rng(seed).standard_normal(count)
        dither = 50 * np.sin(np.arange(count) * 0.0123)  # the motion's, known
        rounded = np.round((white + dither) / step) * step - dither if step else white
        found.append(between(rounded, seed, period))
    f = np.array([*SLOW, 3.0, 0.4 / period])
    levels = np.array([np.interp(f, s.frequencies, s.density) for s in found])
    true_level = 2 * period * (1 + step**2 / 12)
    assert levels.mean(axis=0) == pytest.approx(np.full(4, true_level), rel=0.1)
    assert (np.quantile(levels, 0.9, axis=0) < 1.25 * true_level).all()  # of single logs


@pytest.mark.parametrize(("count", "allowed"), [(2000, 0.25), (5000, 0.1)])
def test_coloured_noise_stays_coloured(count, allowed):
    """A corner of 4.2 Hz, which stretches of half a second hardly resolve."""
    found = [between(noise(count, seed, 1.0, 0.0), seed, 0.004) for seed in range(30)]
    scaled = np.array([*SLOW, 3.0]) * 0.004 / PERIOD  # `true` is of another period
    levels = mean_of(found, np.array([*SLOW, 3.0])) / (true(scaled, 1.0, 0.0) * 0.004 / PERIOD)
    assert levels == pytest.approx(np.ones(3), abs=allowed)


@pytest.mark.parametrize(
    ("sections", "factor"), [(butter(2, 0.04, output="sos"), 2.5), (bessel(4, 0.04, output="sos"), 5)]
)
def test_noise_behind_steeper_filters_is_about_told_where_it_was_not_seen(sections, factor):
    """A corner of 5 Hz; four poles are none of the shapes that are tried. One alone: 25 times less."""
    period, count = 0.004, 5000
    f, white = np.array([0.5, 1.0, 2.0, 4.0]), 0.05
    found = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        slow = np.asarray(sosfilt(sections, rng.standard_normal(count + 500)))[500:]
        found.append(between(slow + white * rng.standard_normal(count), seed, period))
    gain = np.square(np.abs(sosfreqz(sections, f, fs=1 / period)[1]))
    ratio = mean_of(found, f) / (2 * period * (gain + white**2))
    assert (np.abs(np.log(ratio)) < np.log(factor)).all()


def test_there_is_no_more_noise_than_what_is_left():
    """A ripple of 4.5 Hz looks like noise with a corner there, which would be as strong below it."""
    period, count, f = 0.004, 5000, np.array([0.5, 1.0, 2.0])
    turns = 2 * np.pi * 0.05 * np.arange(count) * period
    moving = np.abs(np.sin(turns)) > 0.05
    levels = []
    for seed in range(10):
        white = np.random.default_rng(seed).standard_normal(count)
        found = between_reversals(white + 3 * np.sin(90 * turns), moving, period)
        assert found is not None
        levels.append(np.interp(f, found.frequencies, found.density))
    assert (np.mean(levels, axis=0) < 2 * (2 * period)).all()


def test_noise_of_differences_does_not_raise_what_is_slow():
    """As a loop makes of its encoders': sampled differences of white noise, 4 sin²(pi f T) of its density."""
    period, count = 0.004, 8000
    true_at = np.array([30.0, 60.0, 100.0])
    levels = []
    for seed in range(20):
        white = np.random.default_rng(seed).standard_normal(count + 1)
        found = between(np.diff(white), seed, period)
        levels.append(np.interp(true_at, found.frequencies, found.density))
        assert np.interp(0.5, found.frequencies, found.density) < 0.1 * np.mean(found.density)
    true_levels = 2 * period * 4 * np.sin(np.pi * true_at * period) ** 2
    assert np.mean(levels, axis=0) == pytest.approx(true_levels, rel=0.3)


def test_gaps_are_bridged_without_the_noise_of_single_samples():
    rng, count = np.random.default_rng(0), 8000
    noise = np.diff(rng.standard_normal(count + 1))
    known = np.arange(count) % 100 >= 10
    at = np.arange(count)
    single = np.interp(at, at[known], noise[known])

    def slow(x):  # up to a fiftieth of the Nyquist frequency
        return np.square(np.abs(np.fft.rfft(x))[1:80]).sum()

    assert slow(bridged(noise, known)) < 0.5 * slow(single)
    assert (bridged(noise, known)[known] == noise[known]).all()
    course = 3 + 0.01 * at
    assert np.abs(bridged(course, known) - course)[20:-20].max() < 0.1


def test_noise_is_drawn_with_its_spectrum():
    f = np.linspace(0, 50, 400)
    spectrum = NoiseSpectrum(f, true(f), PERIOD)
    drawn = [spectrum.draw(6000, np.random.default_rng(seed)) for seed in range(10)]
    assert np.mean([np.var(x) for x in drawn]) == pytest.approx(1.25, rel=0.05)
    assert spectrum.std == pytest.approx(np.sqrt(1.25), rel=0.02)
    assert np.mean([np.corrcoef(x[1:], x[:-1])[0, 1] for x in drawn]) == pytest.approx(0.9 / 1.25, abs=0.02)


def test_a_motion_that_repeats_behind_a_run_in_is_found_there():
    """Two seconds on the way there, and a stretch that differs at the end."""
    q = course(np.arange(6000) * PERIOD)
    there = np.linspace(0, 1, 200)[:, None] ** 2 * (q[0] + 0.7)
    back = q[-1] + np.linspace(0, 2, 400)[:, None]
    found = repetition_of(np.vstack([there, q, back]), np.zeros(2))
    assert found is not None
    assert found.period == pytest.approx(777.34, abs=0.05)
    assert found.rows.start >= 200
    assert found.rows.stop <= 6200
    assert repetition_of(there, np.zeros(2)) is None


@pytest.mark.parametrize("share", [1.0, 0.15])
def test_noise_is_not_diluted_by_what_is_not_known(share):
    """A joint that moves in a part of a log only: elsewhere what is left is a straight line."""
    found = []
    for seed in range(6):
        known = np.arange(40000) < share * 40000
        known &= np.arange(40000) % 700 > 10  # reversals
        spectrum = between_reversals(bridged(noise(40000, seed), known), known, PERIOD)
        assert spectrum is not None
        found.append(spectrum)
    f = np.array([0.3, 3.0, 40.0])
    assert mean_of(found, f) == pytest.approx(true(f), rel=0.4)


def test_a_quick_log_shows_noise_as_far_down_as_a_slow_one():
    """Of stretches of about a second, not of a quarter, at 1 kHz."""
    rng = np.random.default_rng(0)
    white, moving = rng.standard_normal(24000), np.ones(24000, bool)
    quick, slow = (
        between_reversals(x, moving[: len(x)], T) for x, T in ((white, 1e-3), (white[:6000], 4e-3))
    )
    assert quick is not None
    assert slow is not None
    assert quick.continued == pytest.approx(slow.continued, rel=0.05)
    assert quick.std == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize(("continued", "low"), [(0.1, 9.0), (20.0, 1.0)])
def test_a_spectrum_is_lowered_but_where_it_alone_was_measured(continued, low):
    f = np.linspace(0.0, 100.0, 101)
    own = NoiseSpectrum(f, np.full(101, 9.0), 0.005, continued=continued)
    found = own.lowered(NoiseSpectrum(np.array([0.0]), np.array([1.0]), 0.005, continued=10.0))
    assert (found.density[5], found.density[50]) == (low, 1.0)
