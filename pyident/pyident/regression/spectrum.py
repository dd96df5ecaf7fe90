"""The regression in the frequency domain, each equation measured against the floor of the method.

A sum of equations is an equation, and so is a Fourier coefficient of them: the masked rows of A p = y are
transformed over time, bin by bin up to a highest frequency. There they are divided by the level that the
method itself leaves at that frequency (differences amplify noise as f squared, held torques and reversals
leave their own pattern), so that all of them weigh alike and low frequencies, where physics is, are not
drowned.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.ndimage import uniform_filter1d

from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.regression.regressor import regressor_blocks

_SMOOTH = 15  # bins over which a floor is averaged
_TOP = 0.2  # of the Nyquist frequency: above, differences, noise and resonances are all there is
_RIGID_TOP = 0.6  # of the same, without resonances and without a loop that answers the noise
_CUT = 0.8  # of the cutoff of the coordinates: above, torques have lost the motion that belongs to them
_THINNED_TOP = 0.8  # of the Nyquist frequency after thinning out


@dataclass(frozen=True)
class Band:
    """The frequencies of one log: N samples padded to `length` [period in s], the first `bins` are kept."""

    length: int
    bins: int
    period: float

    @property
    def frequencies(self) -> np.ndarray:
        """(bins,) [Hz]."""
        return np.arange(self.bins) / (self.length * self.period)

    def transform(self, columns: np.ndarray) -> np.ndarray:
        """(N, ...) -> (2 bins, ...): real over imaginary parts, white noise keeps its variance."""
        spectrum, scale = np.asarray(rfft(columns, self.length, axis=0)), 1 / np.sqrt(self.length / 2)
        out = np.empty((2 * self.bins, *spectrum.shape[1:]))
        np.multiply(np.real(spectrum)[: self.bins], scale, out=out[: self.bins])
        np.multiply(np.imag(spectrum)[: self.bins], scale, out=out[self.bins :])
        return out


@dataclass(frozen=True)
class Floor:
    """rms (n, F) of what the method leaves per equation at `frequencies` (F,) [Hz]."""

    frequencies: np.ndarray
    rms: np.ndarray

    def at(self, band: Band) -> np.ndarray:
        """(n, E) for the equations of a log."""
        level = np.array([np.interp(band.frequencies, self.frequencies, row) for row in self.rms])
        return np.tile(level, 2)


@dataclass(frozen=True)
class Equations:
    """One log's equations. A (n, E, P), y (n, E), E = 2 bins; a law's columns come from `part`."""

    part: Conditioned
    band: Band
    A: np.ndarray
    y: np.ndarray

    def over(self, level: np.ndarray) -> "Equations":
        """Divided by the level of each equation, (n, E), or (n, 1) for all of a row."""
        return Equations(self.part, self.band, self.A / level[:, :, None], self.y / level)


def equations(robot: Robot, parts: Sequence[Conditioned], periods: Sequence[float]) -> list[Equations]:
    """Every conditioned log, transformed; periods [s] per log."""
    return [_equations(robot, part, period) for part, period in zip(parts, periods, strict=True)]


def floor(bands: Sequence[Band], residuals: Sequence[np.ndarray]) -> Floor:
    """From residuals (n, E) of replicas, one per band; smoothed over frequency."""
    longest = max(bands, key=lambda band: band.bins)
    rows = []
    for band, r in zip(bands, residuals, strict=True):
        power = np.square(r[:, : band.bins]) + np.square(r[:, band.bins :])
        smooth = uniform_filter1d(power / 2, min(_SMOOTH, band.bins), axis=1, mode="nearest")
        rows.append([np.interp(longest.frequencies, band.frequencies, s) for s in smooth])
    rms = np.sqrt(np.mean(rows, axis=0))
    return Floor(longest.frequencies, np.maximum(rms, 1e-12 * rms.max()))


def floors(bands: Sequence[Band], residuals: Sequence[np.ndarray], logs: int) -> list[Floor]:
    """Of every log for itself, as a fast motion leaves more than a slow one; its replicas (n, E) in turn."""
    return [floor(bands[i::logs], residuals[i::logs]) for i in range(logs)]


def pooled(levels: Sequence[Floor]) -> Floor:
    """What logs leave on average, for a log of which nothing is known."""
    longest = max(levels, key=lambda level: level.frequencies[-1])
    at = longest.frequencies
    squares = [[np.interp(at, level.frequencies, row**2) for row in level.rms] for level in levels]
    return Floor(at, np.sqrt(np.mean(squares, axis=0)))


def levels_of(levels: Sequence[Floor], data: Sequence[Equations]) -> list[np.ndarray]:
    """Per log (n, E) floors of its equations."""
    return [level.at(e.band) for level, e in zip(levels, data, strict=True)]


def all_over(data: Sequence[Equations], levels: Sequence[np.ndarray]) -> list[Equations]:
    """The equations of logs, each over its level (n, E)."""
    return [e.over(level) for e, level in zip(data, levels, strict=True)]


def _band(samples: int, robot: Robot, period: float) -> Band:
    """Bins from 0 to the highest frequency at which the equations of a log are sound."""
    length = int(next_fast_len(samples, real=True) or samples)
    return Band(length, max(2, int(band_top(robot, period) * length * period)), period)


def band_top(robot: Robot, period: float) -> float:
    """The highest frequency [Hz] at which the equations of a log with this period [s] are sound."""
    along = robot.controller is None and not robot.flexible
    plan = robot.settings.processing
    top = min(_RIGID_TOP if along else _TOP, _THINNED_TOP / plan.decimate) * 0.5 / period
    if plan.cutoff is not None:
        top = min(top, _CUT * plan.cutoff)
    return top if plan.band is None else min(top, plan.band)


def _equations(robot: Robot, part: Conditioned, period: float) -> Equations:
    band = _band(len(part.target), robot, period)
    ((_, whole),) = regressor_blocks(robot, part.motion, block=len(part.target))
    Phi = whole.transpose(1, 2, 0)  # as it lies in memory
    n, P = Phi.shape[:2]
    A = np.zeros((n, 2 * band.bins, P))
    for c in range(n):
        used = np.flatnonzero(Phi[c].any(axis=1))
        A[c][:, used] = band.transform(part.used(c, Phi[c, used]).T)
    return Equations(part, band, A, band.transform(part.all_used(part.target)).T)
