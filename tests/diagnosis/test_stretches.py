"""What laws take of a stretch of a residual, against closed forms and a law that is known to be there."""

import numpy as np
import pytest
from two_link_logs import hidden, inline, loaded, made_log, two_link

from pyident.comparison.compare import compare
from pyident.comparison.traces import Trace
from pyident.diagnosis.stretches.ranking import ranking
from pyident.diagnosis.stretches.waves import LawWave, Waves, waves

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


def test_a_span_without_samples_is_one_sentence(trace):
    with pytest.raises(ValueError, match="has no samples from 7 to 8 s"):
        ranking(Waves((), {KEY: trace.residual}), trace, (7.0, 8.0))


def test_the_law_that_is_there_takes_the_bump(tmp_path):
    """Its own value in the FMU is 2.5 N m; a model with it has nothing to explain."""
    with loaded(hidden(), tmp_path) as fmu:
        logs = [made_log(fmu, hidden(), seed, seconds=5.0) for seed in (1, 2)]
    comparison = compare(two_link(), logs[1:], inline(tmp_path), lambda _: None)
    trace = next(t for t in comparison.traces if t.coordinate == "joint2.e")
    bump = comparison.bumps(trace)[0]
    asked = ranking(waves(two_link(), logs[:1], comparison.floor, logs[1:]), trace, (bump.start, bump.stop))
    best = asked.shares[0]
    assert best.law.name == "asymmetric_coulomb at joint2"
    assert best.percent > 90
    assert best.law.values["coulomb"] == pytest.approx(2.5, rel=0.02)
    assert asked.own_percent < 80
    truth = ranking(waves(hidden(), logs[:1], comparison.floor, logs[1:]), trace, asked.span)
    assert truth.own_percent > 90
