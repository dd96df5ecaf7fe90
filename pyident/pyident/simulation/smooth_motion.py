"""A coordinate without its sensor's noise: a low pass that begins where its spectrum meets the noise.

That is read from the spectrum under a window. Without one, a motion that does not end as it began leaks
into all frequencies, seems to exceed the noise there, and keeps noise that differences raise to accelerations
many times too rough. For the same reason the low pass works on what is left beside a polynomial that has the
value, the second and the fourth derivative of the motion at both ends: its odd continuation is smooth.
"""

import numpy as np
from numpy.polynomial import Chebyshev

_OVER_NOISE = 10.0  # times the noise's power: what of a coordinate's spectrum is motion
_LOWEST, _HIGHEST = 0.005, 0.9  # of the Nyquist frequency: ends of what the motion may reach
_NOTHING = 2.5  # times the frequency that the motion reaches: from there on nothing passes
_RINGS = 1 / (_NOTHING - 1)  # periods of the highest frequency of the motion, until a step has settled
_MOMENT = 128  # samples
_AROUND = 8  # frequencies of a moment's spectrum that are averaged
_ENDS = 0.01  # of the samples, at either end, where a motion goes on that nobody knows
_DEGREE = 5  # of the polynomial that finds an end's derivatives
_FEWEST = 4 * _DEGREE  # samples of it


def smooth(x: np.ndarray, noise: float) -> np.ndarray:
    """(N,) without what lies above the frequencies at which the motion x (N,) exceeds its white noise.

    noise   its standard deviation
    """
    reached = _reached(x, noise)
    course = _course(x, int(np.clip(1 / reached, _FEWEST, max(_FEWEST, len(x) // 3))))
    left = x - course
    S = np.fft.rfft(np.concatenate([left, -left[-2:0:-1]]))
    beyond = (np.linspace(0, 1, len(S)) / reached - 1) / (_NOTHING - 1)
    gain = np.cos(np.pi / 2 * np.clip(beyond, 0, 1)) ** 2
    return course + np.fft.irfft(S * gain, 2 * len(x) - 2)[: len(x)]


def blurred(x: np.ndarray, noise: float) -> int:
    """Samples of x, (N,), on either side over which `smooth` spreads what happens in one of them.

    A reversal of friction is such a thing. noise: deviation of x.
    """
    return int(np.ceil(2 * _RINGS / _reached(x, noise)))


def ends_of(count: int) -> int:
    """How many of so many samples, at either end, are not to be relied on after a low pass."""
    return int(np.ceil(_ENDS * count))


def _reached(x: np.ndarray, noise: float) -> float:
    """The highest frequency of the motion, over the Nyquist frequency: of all of it, or of a moment."""
    window = np.hanning(len(x))
    moved = x - np.linspace(x[0], x[-1], len(x))
    S = np.fft.rfft((moved - moved.mean()) * window)
    power = np.abs(S) ** 2 / np.sum(window**2)
    bins = max(3, len(S) // 200)
    mean = np.convolve(power, np.ones(bins) / bins, mode="same")
    above = np.flatnonzero(mean > _OVER_NOISE * noise**2)
    whole = (above[-1] if len(above) else 0) / len(S)
    return float(np.clip(max(whole, _in_a_moment(x, noise)), _LOWEST, _HIGHEST))


def _in_a_moment(x: np.ndarray, noise: float) -> float:
    """The highest frequency of a motion of a moment, over the Nyquist frequency; 0: there is none.

    Where friction turns round a robot shakes for a few samples, which hardly shows in the spectrum of all.
    Accelerations do not leak as positions would.
    """
    if len(x) < 2 * _MOMENT:
        return 0.0
    window = np.hanning(_MOMENT)
    pieces = np.lib.stride_tricks.sliding_window_view(np.diff(x, 2), _MOMENT)[:: _MOMENT // 2]
    power = np.abs(np.fft.rfft(pieces * window, axis=1)) ** 2 / np.sum(window**2)
    own = noise**2 * (2 - 2 * np.cos(np.linspace(0, np.pi, power.shape[1]))) ** 2
    mean = np.lib.stride_tricks.sliding_window_view(power / np.maximum(own, 1e-300), _AROUND, axis=1).mean(-1)
    above = np.flatnonzero((mean > _OVER_NOISE).any(axis=0))
    last = above[-1] if len(above) else 0
    return (last + _AROUND / 2) / power.shape[1] if last > _AROUND else 0.0


def _course(x: np.ndarray, count: int) -> np.ndarray:
    """(N,) polynomial with the value, second and fourth derivative that x has at both ends.

    count   samples of an end from which they are found
    """
    s = np.linspace(0, 1, len(x))
    back = 1 - s
    (v0, a0, b0), (v1, a1, b1) = (_at_the_end(end[:count], len(x)) for end in (x, x[::-1]))
    curved = a0 * (back**3 - back) / 6 + a1 * (s**3 - s) / 6
    fourth = sum(b * (3 * u**5 - 10 * u**3 + 7 * u) / 360 for b, u in ((b0, back), (b1, s)))
    return v0 * back + v1 * s + curved + fourth


def _at_the_end(x: np.ndarray, whole: int) -> tuple[float, float, float]:
    """Value, second and fourth derivative at the first of samples x, by a time that is 1 after `whole`."""
    fitted = Chebyshev.fit(np.arange(len(x)) / (whole - 1), x, min(_DEGREE, len(x) - 1))
    return float(fitted(0.0)), float(fitted.deriv(2)(0.0)), float(fitted.deriv(4)(0.0))
