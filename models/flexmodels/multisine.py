"""Sums of equally spaced sines with unit rms, and phases that keep their peaks low."""

import numpy as np

_ROUNDS = 200
_OVERSAMPLING = 16
_BLOCK = 2**22  # numbers that are held at once


def wave(time: np.ndarray, frequencies: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """(N,) at times [s]: the sum over lines [Hz] of sin(2 pi f t + phase), scaled to unit rms."""
    rows = max(1, _BLOCK // len(frequencies))
    sums = [
        np.sin(2 * np.pi * time[i : i + rows, None] * frequencies + phases).sum(axis=1)
        for i in range(0, len(time), rows)
    ]
    return np.sqrt(2 / len(frequencies)) * np.concatenate(sums)


def crest_factor(signal: np.ndarray) -> float:
    """Peak over rms of a signal (N,)."""
    return float(np.abs(signal).max() / np.sqrt(np.mean(signal**2)))


def flattened(phases: np.ndarray, frequencies: np.ndarray) -> np.ndarray:
    """Phases (lines,) [rad] with a low crest factor: clip in time, keep the clipped phases, repeat.

    Van der Ouderaa, Schoukens and Renneboog 1988. The lines are taken as harmonics of their spacing; the
    offset of the first line only turns the wave within its envelope.
    """
    lines = len(frequencies)
    size = _OVERSAMPLING * lines
    first = round(frequencies[0] / (frequencies[1] - frequencies[0])) if lines > 1 else 1
    harmonics = np.arange(lines) + max(first, 1)
    best, least = phases, np.inf
    for share in np.linspace(0.75, 0.97, _ROUNDS):
        spectrum = np.zeros(size // 2 + 1, dtype=complex)
        spectrum[harmonics] = np.exp(1j * (phases - np.pi / 2))
        signal = np.fft.irfft(spectrum, size)
        crest = crest_factor(signal)
        if crest < least:
            best, least = phases, crest
        limit = share * np.abs(signal).max()
        clipped = np.fft.rfft(np.clip(signal, -limit, limit))[harmonics]
        phases = np.angle(clipped) + np.pi / 2
    return best
