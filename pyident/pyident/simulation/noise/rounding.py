"""What a loop makes of its encoders' rounding, in a log whose motion repeats.

Rounding is noise to a model, but where a motion repeats it comes back with it, and with it what a controller
answers: a torque, and a shaking of the robot that the low pass of the motion takes for noise. What differs
between the periods shows neither. The answer is read from torques at frequencies that no motion has; the
shaking is what encoders read beyond white noise.
"""

from dataclasses import dataclass

import numpy as np

from pyident.simulation.noise.noise_spectrum import NoiseSpectrum

_AVERAGED = 0.005  # of the spectrum: over so much of it a density is a mean
_ORDERS = 3  # derivatives of a position that a controller answers
_SHAKES = 2.0  # times the white noise: an encoder reads more than that where the robot shakes


@dataclass(frozen=True, eq=False)
class Rounding:
    """Of encoders, at the frequencies f (F,) [Hz] of a log with a period [s].

    read     (F, n) what they read beside the motion that a low pass leaves, behind a Hann window
    density  (F, n) of that, per Hz;  white (n,): where no motion is
    free     (F,) where that is
    shaken   (N, n) accelerations of what they read beyond white noise
    """

    period: float
    f: np.ndarray
    read: np.ndarray
    density: np.ndarray
    white: np.ndarray
    free: np.ndarray
    shaken: np.ndarray

    @staticmethod
    def of(beside: np.ndarray, above: float, period: float) -> "Rounding | None":
        """Of encoders that read this (N, n) beside the smooth motion, which ends below a frequency [Hz]."""
        f = np.fft.rfftfreq(len(beside), period)
        free = f > above
        if not (free.any() and beside.any()):
            return None
        read = np.fft.rfft(beside * np.hanning(len(beside))[:, None], axis=0)
        density = np.column_stack([_density(x, len(beside), period) for x in read.T])
        white = density[free].mean(axis=0)
        share = np.where(density > _SHAKES * white, 1 - white / np.maximum(density, 1e-300), 0.0)
        share[free] = 0.0
        shaken = np.fft.rfft(beside, axis=0) * np.sqrt(share) * (2j * np.pi * f[:, None]) ** 2
        return Rounding(period, f, read, density, white, free, np.fft.irfft(shaken, len(beside), axis=0))

    def answer(self, left: np.ndarray) -> NoiseSpectrum:
        """Of a controller to it, below these frequencies: by gains of position, rate, and its lateness.

        left    (N,) of a torque by a model, which tells them at these frequencies
        """
        s = 2j * np.pi * self.f[:, None]
        columns = np.hstack([s**order * self.read for order in range(_ORDERS)])[self.free]
        target = np.fft.rfft(left * np.hanning(len(left)))[self.free]
        A, y = (np.concatenate([x.real, x.imag]) for x in (columns, target))
        norm = np.linalg.norm(A, axis=0)
        scale = np.where(norm > 0, norm, 1.0)  # encoders that do not round have none
        gains = np.linalg.lstsq(A / scale, y, rcond=1e-9)[0] / scale
        response = sum(s**order * own for order, own in enumerate(np.split(gains, _ORDERS)))
        read = np.maximum(self.density, self.white)  # within the motion the low pass has left none of it
        density = (np.abs(response) ** 2 * read).sum(axis=1)
        return NoiseSpectrum(self.f, np.where(self.free, 0.0, density), self.period)

    def spectrum(self, torque: np.ndarray) -> NoiseSpectrum:
        """Of a torque (N,)."""
        density = _density(np.fft.rfft(torque * np.hanning(len(torque))), len(torque), self.period)
        return NoiseSpectrum(self.f, density, self.period)


def _density(S: np.ndarray, count: int, period: float) -> np.ndarray:
    """(F,) per Hz, of so many samples' transform (F,) behind a Hann window, as a running mean."""
    power = np.abs(S) ** 2 / np.sum(np.hanning(count) ** 2) * 2 * period
    bins = max(3, round(_AVERAGED * len(S)))
    return np.convolve(power, np.ones(bins) / bins, "same")
