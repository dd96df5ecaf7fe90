"""The spectrum of a torque's noise: white near the Nyquist frequency, and several times that at low ones.

Currents are filtered, drives ripple, and estimates of torque drift for seconds. A floor that holds the white
part alone is too low where the physics is, and all that exceeds it reads as something missing.

What the fitted model leaves of a torque, along the motion without its sensors' noise, holds noise and what
the model lacks. Where the motion repeats, noise is what does not (see `repetition`). Else it is what is left
between reversals in stretches so short that a law is a cubic there; below the frequencies that these resolve,
the spectrum is that of white and of low-passed noise which fit it best above.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import nnls

from pyident.simulation.repetition import unrepeated

_WINDOWS = (256, 128, 64, 32)  # samples of a stretch without reversals, the longest first
_ENOUGH = 12  # stretches
_SMOOTH = 3  # degree of what a law may leave within one
_FIRST = 4  # bin from which on nothing of it is left
_WIDER = 1.25  # each band's width in which a spectrum is averaged, over the one's before
_BINS = 8  # in a band at least
_CORNERS = 15  # of low passes that are tried
_ROUNDS = 4  # after which their sizes change by less than a per cent


@dataclass(frozen=True)
class NoiseSpectrum:
    """Noise of a channel that is sampled with a period [s].

    frequencies, density   (F,) Hz, and unit² per Hz, of positive frequencies alone
    """

    frequencies: np.ndarray
    density: np.ndarray
    period: float

    @staticmethod
    def white(sigma: float, period: float) -> "NoiseSpectrum":
        """Of a standard deviation."""
        return NoiseSpectrum(np.array([0.0]), np.array([2 * sigma**2 * period]), period)

    @property
    def std(self) -> float:
        """Of the noise."""
        f = np.linspace(0, 0.5 / self.period, 1000)
        return float(np.sqrt(self._at(f).mean() * f[-1]))

    def without_rounding(self, step: float) -> "NoiseSpectrum":
        """What else there is in a channel of this resolution."""
        rounding = step**2 / 12 * 2 * self.period
        return NoiseSpectrum(self.frequencies, np.maximum(self.density - rounding, 0.0), self.period)

    def draw(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """(count,) samples."""
        white = np.fft.rfft(rng.standard_normal(count))
        f = np.fft.rfftfreq(count, self.period)
        return np.fft.irfft(white * np.sqrt(self._at(f) / (2 * self.period)), count)

    def _at(self, f: np.ndarray) -> np.ndarray:
        return np.interp(f, self.frequencies, self.density)


def repeated_spectrum(left: np.ndarray, repeats: float, period: float) -> NoiseSpectrum:
    """Of what a model leaves (N,) along a motion that repeats after so many samples."""
    noise, step = unrepeated(left, repeats)
    window = np.hanning(len(noise))
    S = np.abs(np.fft.rfft((noise - noise.mean()) * window)) ** 2 / np.sum(window**2) * 2 * period * step
    narrowest = max(_BINS, round(len(noise) * step / repeats))  # a harmonic of the motion in every band
    edges = [max(1, narrowest // 2)]  # slower is a course over the periods
    while edges[-1] + narrowest < len(S):
        edges.append(min(len(S), max(edges[-1] + narrowest, int(_WIDER * edges[-1]))))
    bins = 1 / (len(noise) * step * period)
    middle = [0.5 * (a + b - 1) * bins for a, b in pairwise(edges)]
    return NoiseSpectrum(np.array(middle), np.array([S[a:b].mean() for a, b in pairwise(edges)]), period)


def between_reversals(left: np.ndarray, moving: np.ndarray, period: float) -> NoiseSpectrum | None:
    """Of what a model leaves (N,), where a joint keeps its direction (N,); None where it hardly does."""
    for length in _WINDOWS:
        starts = range(0, len(left) - length + 1, length // 2)
        pieces = np.array([left[a : a + length] for a in starts if moving[a : a + length].all()])
        if len(pieces) >= _ENOUGH:
            return _fitted(pieces, period)
    return None


def _fitted(pieces: np.ndarray, period: float) -> NoiseSpectrum:
    """White and low-passed noise by the spectrum of pieces (M, L)."""
    length = pieces.shape[1]
    basis = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1, 1, length), _SMOOTH))[0]
    window = np.hanning(length)
    smooth = pieces @ basis @ basis.T
    S = np.abs(np.fft.rfft((pieces - smooth) * window, axis=1)) ** 2 / np.sum(window**2) * 2 * period
    f = np.fft.rfftfreq(length, period)
    typical = np.median(S, axis=0)[_FIRST:-1] / np.log(2)
    f_seen, top = f[_FIRST:-1], f[-1]
    fine = np.linspace(0, top, 200)
    best, least = np.zeros(len(fine)), np.inf
    for corner in np.geomspace(f_seen[0] / 2, top / 3, _CORNERS):
        shapes = [np.column_stack([np.ones_like(x), 1 / (1 + (x / corner) ** 2)]) for x in (f_seen, fine)]
        model = np.full(len(typical), typical.mean())
        for _ in range(_ROUNDS):  # over the typical values themselves it would lean on the lowest
            size = nnls(shapes[0] / model[:, None], typical / model)[0]
            model = np.maximum(shapes[0] @ size, 1e-6 * typical.mean())
        miss = float(np.sum(np.log(model) + typical / model))  # Whittle's likelihood
        if miss < least:
            best, least = shapes[1] @ size, miss
    return NoiseSpectrum(fine, best, period)
