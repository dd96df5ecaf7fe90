"""Two-stage least squares finds what least squares underrates."""

import numpy as np
import pytest
from studies.kuka_kr300.instrumental import STRONG, two_stage

K, OFFSET = 5.0, 2.0


def _record(rng, noise=0.5):
    """A signal that follows two instruments, seen with errors, and what it makes."""
    t = np.arange(800) * 0.02
    instruments = np.column_stack([np.sin(t), np.cos(2.3 * t), np.sin(7 * t)])
    true = instruments @ [1.0, 0.6, 0.0]
    coloured = np.convolve(rng.normal(size=len(t) + 9), np.ones(10) / 10, "valid")
    y = K * true + OFFSET + coloured
    return true + noise * rng.normal(size=len(t)), np.ones((len(t), 1)), instruments, y


def test_interval_covers_the_truth_where_least_squares_is_biased():
    covered, plain = [], []
    for seed in range(60):
        signal, exact, instruments, y = _record(np.random.default_rng(seed))
        found = two_stage(signal, exact, instruments, y, lags=25)
        covered.append(abs(found.p[0] - K) < 1.96 * found.std[0])
        plain.append(np.linalg.lstsq(np.column_stack([signal, exact]), y, rcond=None)[0][0])
    assert np.mean(covered) > 0.85
    assert np.mean(plain) < 0.8 * K


def test_without_errors_it_is_exact():
    signal, exact, instruments, _ = _record(np.random.default_rng(0), noise=0.0)
    found = two_stage(signal, exact, instruments, K * signal + OFFSET, lags=3)
    assert found.p == pytest.approx([K, OFFSET])
    assert found.residual == pytest.approx(np.zeros(len(signal)), abs=1e-9)


def test_instruments_that_tell_nothing_are_weak():
    rng = np.random.default_rng(1)
    signal, exact, instruments, y = _record(rng)
    assert two_stage(signal, exact, instruments, y, lags=25).F > STRONG
    foreign = rng.normal(size=instruments.shape)
    assert two_stage(signal, exact, foreign, y, lags=25).F < STRONG
