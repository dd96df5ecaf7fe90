"""Instruments without noisy frequencies: less scatter where noise grows, nothing lost elsewhere."""

import numpy as np
import pytest

from pyident.conditioning.motion import Motion
from pyident.conditioning.samples import Conditioned
from pyident.estimation.instrumental_variables import Rows, moment_equations, unknown
from pyident.refinement.instruments.noise_weights import counted_alike, counted_by_noise
from pyident.refinement.instruments.simulated_rows import Data
from pyident.regression.reduced import reduce

N, TRUE = 4000, np.array([2.0, -1.0])


def drawn(noise: np.ndarray, seed: int) -> tuple[Data, Rows]:
    """One equation of two columns of all frequencies, whose exact values are the instruments."""
    columns = np.random.default_rng(seed).standard_normal((N, 1, 2))
    y = columns @ TRUE + noise[:, None]
    none = np.zeros((N, 1))
    part = Conditioned(Motion(none, none, none, none), y, np.ones((N, 1)), 1)
    return Data(part, columns, y, np.ones((N, 1))), Rows(columns, columns, y, np.ones((N, 1)))


def estimated(rows: list[Rows], weights: np.ndarray) -> np.ndarray:
    reduced = reduce([(r.A.copy(), r.y.copy()) for r in rows], ("a",), ("u", "v"))
    return moment_equations(lambda: rows, reduced, weights).solve(unknown, 2).p


def scatter(shape) -> tuple[float, float]:
    """rms errors with the weights and without, of twenty draws; shape: cycles per sample -> amplitude."""
    errors = []
    for seed in range(20):
        white = np.random.default_rng(100 + seed).standard_normal(N)
        noise = np.fft.irfft(np.fft.rfft(white) * shape(np.fft.rfftfreq(N)), N)
        data, rows = drawn(noise, seed)
        counted, weights = counted_by_noise([data], [rows], TRUE)
        errors.append([estimated(counted, weights) - TRUE, estimated([rows], np.ones(1)) - TRUE])
    with_, without = np.sqrt(np.mean(np.square(errors), axis=(0, 2)))
    return float(with_), float(without)


def test_noise_of_second_differences_loses_most_of_its_doing():
    """The best linear estimate of white columns has the harmonic mean of the noise's power."""
    ours, plain = scatter(lambda f: np.sqrt(1 + (10 * f) ** 4))
    f = np.fft.rfftfreq(N)
    power = 1 + (10 * f) ** 4
    best = np.sqrt(1 / np.mean(1 / power) / np.mean(power))
    assert best < 0.4
    assert ours / plain == pytest.approx(best, rel=0.35)


def test_what_falls_with_frequency_or_is_flat_counts_as_before():
    for shape in (lambda f: 1 / (0.02 + f), np.ones_like):
        ours, plain = scatter(shape)
        assert ours == pytest.approx(plain, rel=0.1)


def test_what_samples_do_counts_as_noise_does():
    """Shifts of high frequencies, taken from the log already, filter the instruments; slow ones do not."""
    data, rows = drawn(0.1 * np.random.default_rng(0).standard_normal(N), 0)
    fast, slow = (np.sin(2 * np.pi * f * np.arange(N))[:, None] for f in (0.3, 0.002))
    levels = []
    for shift in (fast, slow):
        moved = Rows(rows.A, rows.Z, rows.y - 5 * shift, rows.share)
        (counted,), _ = counted_by_noise([data], [moved], TRUE)
        lines = np.abs(np.fft.rfft(counted.Z[:, 0, 0]))
        levels.append(lines[-200:].mean() / np.abs(np.fft.rfft(rows.Z[:, 0, 0]))[-200:].mean())
    assert levels[0] < 0.2
    assert levels[1] > 0.5


def test_where_no_loop_is_known_every_frequency_counts_alike():
    white = np.random.default_rng(5).standard_normal(N)
    slow = 3 * np.sin(2 * np.pi * 0.001 * np.arange(N))
    rows = [drawn(0.2 * white, 0)[1], drawn(slow, 1)[1]]
    weights = counted_alike(rows, TRUE)
    assert 1 / weights[0] == pytest.approx(np.sqrt((0.2**2 + 3**2 / 2) / 2), rel=0.02)
