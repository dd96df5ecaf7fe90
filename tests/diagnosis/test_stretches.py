"""What laws take of a stretch of a residual, against closed forms and a law that is known to be there."""

from dataclasses import replace

import numpy as np
import pytest
from two_link_logs import hidden, loaded, made_log, two_link

from pyident.comparison.traces import Trace, in_band, low_passed
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.stretches.ranking import ranking
from pyident.diagnosis.stretches.waves import LawWave, Waves, waves
from pyident.regression.spectrum import Floor, equations, floor

N, RATE = 4000, 1000.0
TIME = np.arange(N) / RATE
KEY = ("log", "joint1.e")


def law(name: str, taken: np.ndarray) -> LawWave:
    return LawWave(name, "joint1", {"a": 1.0}, {"a": "N m"}, "", {KEY: taken})


@pytest.fixture
def trace() -> Trace:
    """A slow sine in the first half, noise of the replicas of 0.01 N m rms everywhere."""
    residual = np.where(TIME < 2, np.sin(2 * np.pi * TIME), 0.0)
    edge = np.full(N, 0.01 * 1.645)
    return Trace(*KEY, TIME, TIME, TIME, None, residual, 0 * TIME, residual, -edge, edge, TIME >= 0, 1e6)


def test_shares_are_those_of_the_squares(trace):
    """Half of a sine taken leaves a quarter of its square; a cosine as large, over whole turns, adds one."""
    halved = law("half", 0.5 * trace.residual)
    beside = law("beside", np.where(TIME < 2, np.cos(2 * np.pi * TIME), 0.0))
    asked = ranking(Waves((beside, halved), {KEY: trace.residual}), trace, (0.0, 2.0))
    assert [s.law.effect for s in asked.shares] == ["half", "beside"]
    assert asked.shares[0].percent == pytest.approx(75 * 0.5 / (0.5 - 1e-4), rel=1e-3)
    assert asked.shares[1].percent == pytest.approx(-100, rel=2e-3)
    assert asked.own_percent == pytest.approx(0, abs=1e-9)
    assert asked.own_leaves == asked.over_floor == pytest.approx(np.sqrt(0.5) / 0.01, rel=1e-3)
    assert [s.shown for s in asked.shares] == [asked.shares[0].percent, 0.0]
    np.testing.assert_allclose(asked.shares[0].left + asked.shares[0].waveform, trace.residual, atol=1e-12)


def test_only_the_stretch_counts(trace):
    late = law("late", np.where(TIME < 2, 0.0, 5.0))
    whole = law("whole", trace.residual)
    asked = ranking(Waves((late, whole), {KEY: trace.residual}), trace, (0.0, 1.9))
    assert asked.shares[0].law.effect == "whole"
    assert asked.shares[1].percent == pytest.approx(0, abs=1e-9)


def test_a_tie_is_what_replicas_would_hide(trace):
    """Waveforms that differ by less than 0.01 N m rms are one; by more they are two."""
    near, far = (law(n, trace.residual + d) for n, d in (("near", 0.009), ("far", 0.011)))
    best = law("best", trace.residual)
    asked = ranking(Waves((far, near, best), {KEY: trace.residual}), trace)
    assert [s.law.effect for s in asked.tie] == ["best", "near"]


def test_only_the_frequencies_of_a_band_count(trace):
    """A strong slow sine and a weak fast one: each law takes one of them whole."""
    fast = 0.1 * np.sin(2 * np.pi * 40 * TIME)
    both = replace(trace, residual=trace.residual + fast, measured=trace.residual + fast, modelled=0 * TIME)
    level = Floor(np.linspace(0, 100, 201), np.full((1, 201), 0.001))
    laws = Waves((law("fast", fast), law("slow", trace.residual)), {KEY: both.residual})
    assert ranking(laws, both).shares[0].law.effect == "slow"
    asked = ranking(laws, in_band(both, level, 0, (20.0, 60.0)), (0.5, 3.5))
    assert asked.band == (20.0, 60.0)
    assert [s.law.effect for s in asked.shares] == ["fast", "slow"]
    assert asked.shares[0].percent == pytest.approx(100, abs=0.5)
    assert abs(asked.shares[1].percent) < 1


def test_what_is_not_used_is_not_in_a_band(trace):
    """Where friction is not known, a large residual means nothing: not beside it either."""
    spoilt = np.where(TIME < 0.2, 50.0, trace.residual)
    masked = replace(trace, measured=spoilt, modelled=0 * TIME, used=TIME >= 0.2)
    clean = replace(masked, measured=np.where(TIME < 0.2, 0.0, trace.residual))
    level = Floor(np.linspace(0, 100, 201), np.full((1, 201), 0.001))
    found, expected = (in_band(t, level, 0, (0.0, 5.0)).residual for t in (masked, clean))
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("band", [(0.0, 30.0), (50.0, 150.0), (300.0, 500.0), (0.0, 500.0)])
def test_the_ribbon_of_a_band_is_what_noise_has_in_it(trace, band):
    """White noise of 0.3 N m, of which a band holds its share of the Nyquist frequency."""
    noise = 0.3 * np.random.default_rng(1).standard_normal(N)
    level = Floor(np.linspace(0, RATE / 2, 2001), np.full((1, 2001), 0.3))
    found = in_band(replace(trace, measured=noise, modelled=0 * noise), level, 0, band)
    expected = 0.3 * np.sqrt((band[1] - band[0]) / (RATE / 2))
    assert found.high == pytest.approx(1.645 * expected, rel=1e-3)
    assert found.residual.std() == pytest.approx(expected, rel=0.1)
    np.testing.assert_array_equal(found.passed(noise), found.residual)


def test_a_span_without_samples_is_one_sentence(trace):
    with pytest.raises(ValueError, match="has no samples from 7 to 8 s"):
        ranking(Waves((), {KEY: trace.residual}), trace, (7.0, 8.0))


def test_the_law_that_is_there_takes_the_residual(tmp_path):
    """Its value in the FMU is 2.5 N m; the floor is what the true model leaves, the log one not fitted."""
    with loaded(hidden(), tmp_path) as fmu:
        logs = [made_log(fmu, hidden(), seed, seconds=5.0) for seed in (1, 2)]
    parts = equations(hidden(), [condition(log, hidden()) for log in logs], [log.period for log in logs])
    level = floor([e.band for e in parts], solve_base(parts).residual)
    plain = waves(two_link(), logs[:1], level, logs[1:])
    true = waves(hidden(), logs[:1], level, logs[1:])
    residual, rest = (w.refitted["log 2", "joint2.e"].astype(float) for w in (plain, true))
    time, edge = np.arange(len(residual)) / 250, np.full(len(residual), 0.05)
    whole = Trace(
        "log 2", "joint2.e", time, time, time, None, time, time, residual, -edge, edge, time >= 0, 50.0
    )
    best = ranking(plain, whole).shares[0]
    assert best.law.name == "asymmetric_coulomb at joint2"
    assert best.percent > 90
    assert best.law.values["coulomb"] == pytest.approx(2.5, rel=0.02)
    assert best.law.values["viscous"] == pytest.approx(4.0, rel=0.02)
    np.testing.assert_allclose(best.left, low_passed(rest, 1 / 250, 50.0), atol=0.2 * float(np.std(residual)))
