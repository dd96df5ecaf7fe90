"""The spectrum of a torque's noise: white near the Nyquist frequency, and several times that at low ones.

Currents are filtered, drives ripple, and estimates of torque drift for seconds. A floor that holds the white
part alone is too low where the physics is, and all that exceeds it reads as something missing.

What the fitted model leaves of a torque, along the motion without its sensors' noise, holds noise and what
the model lacks. Where the motion repeats, noise is what does not (see `repetition`). Else it is what is left
between reversals in stretches so short that a law is a cubic there; below the frequencies that these resolve,
the spectrum is that of white noise and of noise behind a low pass of one or two poles, as drives filter their
currents, which fit it best above; but there is no more noise than all that the model leaves.

In a loop an encoder's noise becomes torque by differences, and the arm hardly follows it: such a spectrum
rises towards its corner by decades. From where it rises it is taken as it is seen, and the fit is of what
lies below. Of a coarse encoder it is a tone, of a count for each period: most stretches hold little of it at
any frequency, and it comes again with the motion. So above the frequencies of the motion the mean of all that
is left counts, where else the median does, or what does not repeat.

In a few stretches a low pass fits even white noise, and would raise it severalfold where nothing is seen. So
white noise alone and with a low pass are averaged by their odds (Schwarz 1978). Noise whose corner is below
what the stretches resolve is told too small under it, as nothing says how far it goes on rising.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import nnls
from scipy.special import digamma, polygamma
from scipy.stats import chi2

from pyident.simulation.noise.repetition import unrepeated

_WINDOWS = (256, 128, 64, 32)  # samples of a stretch without reversals, the longest first
_LONG, _QUICK = (1024, 512), 1.1  # the same of quick logs, where they last no longer [s]
_ENOUGH = 12  # stretches
_SMOOTH = 3  # degree of what a law may leave within one
_FIRST = 4  # bin from which on nothing of it is left
_WIDER = 1.25  # each band's width in which a spectrum is averaged, over the one's before
_BINS = 8  # in a band at least
_FINE = 200  # frequencies of a spectrum
_ORDERS = (1, 2)  # poles of low passes that are tried
_CORNERS = 15  # of each
_ROUNDS = 4  # after which their sizes change by less than a per cent
_LEAST = 1e-6  # of the mean density
_BRIDGED = 17  # samples whose mean a line over others begins at
_RISES = 4.0  # times the least density at lower frequencies: there noise of another kind begins
_AVERAGED = 3  # bins
_CERTAIN = 50.0  # logarithm of odds: more is not needed
_OCTAVE = 24  # bins of a spectrum that are told from what a fit leaves
_NEWS = 1.5  # bins of Hann's window for one that is news
_SURE = 0.05  # that noise is stronger than what is left says
_FURTHER = 2  # parameters of low-passed noise beside white: its corner and its size
_TOLD = (
    0.95 * 0.51 * 0.48
)  # of a stretch's bins are news: halves overlap, Hann's bins do, and a median is coarse


@dataclass(frozen=True)
class NoiseSpectrum:
    """Noise of a channel that is sampled with a period [s].

    frequencies, density   (F,) Hz, and unit² per Hz, of positive frequencies alone
    continued              Hz: below, it was not measured but continued
    freedom                (F,) degrees of freedom with which each density was measured; none: it is known
    """

    frequencies: np.ndarray
    density: np.ndarray
    period: float
    continued: float = 0.0
    freedom: np.ndarray | None = None

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
        return replace(self, density=np.maximum(self.density - rounding, 0.0))

    def raised(self, other: "NoiseSpectrum", above: float) -> "NoiseSpectrum":
        """With no less than another at frequencies above one [Hz]."""
        f, own = self.frequencies, self.density
        return replace(self, density=np.where(f > above, np.maximum(own, other._at(f)), own))

    def lowered(self, most: "NoiseSpectrum") -> "NoiseSpectrum":
        """With no more than another, but where this one was measured and the other was not."""
        f, own = self.frequencies, self.density
        known = (self.continued < most.continued) & (f < most.continued)
        return replace(self, density=np.where(known, own, np.minimum(own, most._at(f))))

    def draw(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """(count,) samples, of one of the spectra that may be what was measured."""
        white = np.fft.rfft(rng.standard_normal(count))
        f = np.fft.rfftfreq(count, self.period)
        return np.fft.irfft(white * np.sqrt(self._drawn(rng)._at(f) / (2 * self.period)), count)

    def _drawn(self, rng: np.random.Generator) -> "NoiseSpectrum":
        """Densities as few bins tell them: logarithms with mean and variance of a scaled inverse χ²."""
        if self.freedom is None:
            return self
        half = self.freedom / 2
        chance = np.sqrt(polygamma(1, half)) * rng.standard_normal(len(half))
        return replace(
            self, density=self.density * np.exp(np.log(half) - digamma(half) + chance), freedom=None
        )

    def _at(self, f: np.ndarray) -> np.ndarray:
        return np.interp(f, self.frequencies, self.density)


def bridged(left: np.ndarray, known: np.ndarray) -> np.ndarray:
    """What a model leaves (N,), with straight lines over what is not known (N,).

    A line begins at the mean of some samples before. At a single one it would begin with all its noise, and
    spread that of high frequencies over low ones.
    """
    weight = np.convolve(known, np.ones(_BRIDGED), "same")
    mean = np.convolve(np.where(known, left, 0.0), np.ones(_BRIDGED), "same") / np.maximum(weight, 1.0)
    at = np.arange(len(left))
    return np.where(known, left, np.interp(at, at[known], mean[known]))


def repeated_spectrum(left: np.ndarray, repeats: float, period: float) -> NoiseSpectrum:
    """Of what a model leaves (N,) along a motion that repeats after so many samples."""
    noise, step, kept = unrepeated(left, repeats)
    window = np.hanning(len(noise))
    S = np.abs(np.fft.rfft((noise - noise.mean()) * window)) ** 2 / np.sum(window**2) * 2 * period * step
    narrowest = max(_BINS, round(len(noise) * step / repeats))  # a harmonic of the motion in every band
    edges = [max(1, narrowest // 2)]  # slower is a course over the periods
    while edges[-1] + narrowest < len(S):
        edges.append(min(len(S), max(edges[-1] + narrowest, int(_WIDER * edges[-1]))))
    bins = 1 / (len(noise) * step * period)
    middle = np.array([0.5 * (a + b - 1) * bins for a, b in pairwise(edges)])
    density = np.array([S[a:b].mean() for a, b in pairwise(edges)])
    freedom = 2 * kept / _NEWS * np.diff(edges)
    return NoiseSpectrum(middle, density, period, continued=edges[0] * bins, freedom=freedom)


def between_reversals(
    left: np.ndarray, moving: np.ndarray, period: float, above: float = np.inf
) -> NoiseSpectrum | None:
    """Of what a model leaves (N,), where a joint keeps its direction (N,); None where it hardly does.

    above   Hz: the motion has no higher frequencies, so that all that is left there is noise
    """
    for length in (*(n for n in _LONG if n * period <= _QUICK), *_WINDOWS):
        starts = range(0, len(left) - length + 1, length // 2)
        pieces = np.array([left[a : a + length] for a in starts if moving[a : a + length].all()])
        if len(pieces) >= _ENOUGH:
            return _no_more_than(left, moving, _fitted(pieces, period, above))
    return None


def share_told(known: np.ndarray) -> float:
    """Of the power of noise in a signal behind a Hann window, where straight lines hold none; known (N,)."""
    window = np.square(np.hanning(len(known)))
    return float(window[known].sum() / window.sum()) if known.any() else 1.0


def _no_more_than(left: np.ndarray, known: np.ndarray, found: NoiseSpectrum) -> NoiseSpectrum:
    """A spectrum that was continued, with no more noise than all that is left (N,), octave by octave.

    The fit of the model has taken some of the noise, in the lowest octaves most: they count as one.

    known   (N,) where what is left is no straight line
    """
    window = np.hanning(len(left))
    S = np.abs(np.fft.rfft((left - left.mean()) * window)) ** 2 / np.sum(window**2) * 2 * found.period
    S /= share_told(known)
    edges = [int(found.continued * len(left) * found.period)]
    while edges[-1] >= 2 * _OCTAVE:
        edges.append(edges[-1] // 2)
    density, f = found.density, found.frequencies * len(left) * found.period
    for low, high in pairwise([0, *reversed(edges)]):
        if high - low < _OCTAVE:
            continue
        times = (high - low) / _NEWS  # that the band's density is seen
        most = 2 * times / chi2.ppf(_SURE, 2 * times) * S[low:high].mean()
        density = np.where((low <= f) & (f < high), np.minimum(density, most), density)
    return replace(found, density=density)


def _fitted(pieces: np.ndarray, period: float, above: float) -> NoiseSpectrum:
    """White and low-passed noise by the spectrum of pieces (M, L), and above them what rises."""
    f, typical, mean = _seen(pieces, period)
    seen = np.convolve(np.pad(typical, _AVERAGED // 2, mode="edge"), np.ones(_AVERAGED) / _AVERAGED, "valid")
    fine = np.linspace(0, 0.5 / period, _FINE)
    quiet = _before_a_rise(seen)
    low = _by_shapes(f[:quiet], typical[:quiet], fine, len(pieces))
    density = np.where(fine <= f[quiet - 1], low, np.interp(fine, f, seen)) if quiet < len(f) else low
    whole = NoiseSpectrum(f, mean, period)
    return NoiseSpectrum(fine, density, period, continued=float(f[0])).raised(whole, above)


def _before_a_rise(seen: np.ndarray) -> int:
    """How many of the lowest bins of a density (F,) lie before it rises."""
    rises = np.flatnonzero(seen > _RISES * np.minimum.accumulate(seen))
    return int(rises[0]) if len(rises) else len(seen)


def _by_shapes(f: np.ndarray, typical: np.ndarray, fine: np.ndarray, pieces: int) -> np.ndarray:
    """Density at the frequencies `fine` of the white and low-passed noise that fits (F,) at f best."""
    white = float(typical.mean())
    corners = [(c, order) for c in np.geomspace(f[0] / 2, fine[-1] / 3, _CORNERS) for order in _ORDERS]
    fits = [_low_passed(f, typical, *corner) for corner in corners]
    misses = [_miss(typical, _shapes(f, *c) @ size) for c, size in zip(corners, fits, strict=True)]
    best = int(np.argmin(misses))
    told = _TOLD * pieces  # times each bin is seen
    gain = told * (_miss(typical, np.full(len(f), white)) - misses[best])
    odds = np.exp(min(gain - _FURTHER / 2 * np.log(told * len(f)), _CERTAIN))
    return (white + odds * _shapes(fine, *corners[best]) @ fits[best]) / (1 + odds)


def _seen(pieces: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies [Hz] that pieces (M, L) resolve, the density that they typically have there, and the mean.

    What is typical is a median, which what a law leaves in some of them does not move.
    """
    length = pieces.shape[1]
    basis = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1, 1, length), _SMOOTH))[0]
    window = np.hanning(length)
    smooth = pieces @ basis @ basis.T
    S = np.abs(np.fft.rfft((pieces - smooth) * window, axis=1)) ** 2 / np.sum(window**2) * 2 * period
    told = slice(_FIRST, -1)
    typical = np.median(S, axis=0) / np.log(2)
    return np.fft.rfftfreq(length, period)[told], typical[told], S.mean(axis=0)[told]


def _low_passed(f: np.ndarray, typical: np.ndarray, corner: float, order: int) -> np.ndarray:
    """(2,) sizes of white noise and of noise behind a low pass of a corner [Hz] beside it."""
    shapes, model, size = _shapes(f, corner, order), np.full(len(f), typical.mean()), np.zeros(2)
    for _ in range(_ROUNDS):  # over the typical values themselves it would lean on the lowest
        size = nnls(shapes / model[:, None], typical / model)[0]
        model = np.maximum(shapes @ size, _LEAST * typical.mean())
    return size


def _shapes(f: np.ndarray, corner: float, order: int) -> np.ndarray:
    return np.column_stack([np.ones_like(f), 1 / (1 + (f / corner) ** (2 * order))])


def _miss(typical: np.ndarray, model: np.ndarray) -> float:
    """What Whittle's likelihood has against a model of a density, of a spectrum that is seen once."""
    model = np.maximum(model, _LEAST * typical.mean())
    return float(np.sum(np.log(model) + typical / model))
