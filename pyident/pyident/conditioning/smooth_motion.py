"""A coordinate without its sensor's noise: a low pass that begins where its spectrum nears the noise.

That is read from the spectrum under a window. Without one, a motion that does not end as it began leaks
into all frequencies, seems to exceed the noise there, and keeps noise that differences raise to accelerations
many times too rough. For the same reason the low pass works on what is left beside a curve that has the
value, the second and the fourth derivative of the motion at both ends: its odd continuation is smooth.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.chebyshev import chebvander
from scipy.fft import irfft, next_fast_len, rfft

from pyident.conditioning.motion import Motion

_OVER_NOISE = 100.0  # times the noise's power: there it bends a parameter by a hundredth
_LOWEST, _HIGHEST = 0.005, 0.9  # of the Nyquist frequency: ends of what the motion may reach
_NOTHING = 2.5  # times the frequency that the motion reaches: from there on nothing passes
_RINGS = 1 / (_NOTHING - 1)  # periods of the highest frequency of the motion, until a step has settled
_ENDS = (0.01, 0.05)  # of the samples, at either end, where a motion goes on that nobody knows: between
_SETTLED = 3  # times what the low pass blurs: beside an end of a motion just below its corner
WHITE_FROM = 0.6  # of the Nyquist frequency: above, a feed-forward torque has nothing
_DEGREE = 5  # of the polynomial that finds an end's derivatives
_FEWEST = 4 * _DEGREE  # samples of it
_LENGTHS = (2.0, 4.0)  # of the samples of an end's derivatives: over which curves with these fade
_BEYOND = 0.25  # of these samples: so far the polynomial goes on without their noise growing
SHORTEST = 10 * _FEWEST  # samples of a motion that tells its noise


def smooth(x: np.ndarray, corner: float) -> np.ndarray:
    """(N,) what a motion x (N,) is below a corner, over the Nyquist frequency, as of `reached`."""
    count = min(int(np.clip(1 / corner, _FEWEST, max(_FEWEST, len(x) // 3))), len(x))
    whole = _continued(x, count)
    course = _course(whole, count)
    left = whole - course
    S = np.asarray(rfft(np.concatenate([left, -left[-2:0:-1]])))
    beyond = (np.linspace(0, 1, len(S)) / corner - 1) / (_NOTHING - 1)
    gain = np.cos(np.pi / 2 * np.clip(beyond, 0, 1)) ** 2
    return (course + np.asarray(irfft(S * gain, 2 * len(whole) - 2))[: len(whole)])[: len(x)]


def all_smooth(values: np.ndarray, corners: Sequence[float]) -> np.ndarray:
    """(N, n) what `smooth` leaves of coordinates (N, n), each below its corner."""
    return np.column_stack([smooth(x, corner) for x, corner in zip(values.T, corners, strict=True)])


def without_noise(motion: Motion) -> Motion:
    """A log's motion below the frequency at which the noise of each coordinate begins.

    As it is where it is no log's, without times, and where torques are held, as means under hats have less.
    """
    if motion.time is None or motion.tau_before is not None or len(motion.q) < SHORTEST:
        return motion
    corners = all_reached(motion.q)
    q, dq, ddq = (all_smooth(rate, corners) for rate in (motion.q, motion.dq, motion.ddq))
    return replace(motion, q=q, dq=dq, ddq=ddq)


def blurred(corner: float) -> int:
    """Samples on either side over which `smooth` spreads what happens in one: a reversal of friction."""
    return int(np.ceil(2 * _RINGS / corner))


def ends_of(count: int, blurs: Sequence[int]) -> int:
    """How many of so many samples, at either end, are not to be relied on after a low pass.

    blurs   as of `blurred`, by coordinate
    """
    least, most = (int(np.ceil(share * count)) for share in _ENDS)
    return min(max(least, _SETTLED * max(blurs)), most)


def reached(x: np.ndarray, noise: float) -> float:
    """The highest frequency of a motion x (N,), over the Nyquist frequency, that noise does not blur.

    noise: the standard deviation of the white noise in x.
    Not every frequency at which it shows: what a controller makes of its encoder's noise shows as well, up to
    ten times that noise in a poor loop, and belongs to the torque by the controller's law, not the robot's.
    """
    window = np.hanning(len(x))
    moved = x - np.linspace(x[0], x[-1], len(x))
    S = np.fft.rfft((moved - moved.mean()) * window)
    power = np.abs(S) ** 2 / np.sum(window**2)
    bins = max(3, len(S) // 200)
    mean = np.convolve(power, np.ones(bins) / bins, mode="same")
    above = np.flatnonzero(mean > _OVER_NOISE * noise**2)
    return float(np.clip((above[-1] if len(above) else 0) / len(S), _LOWEST, _HIGHEST))


def all_reached(values: np.ndarray) -> list[float]:
    """Of each of the coordinates (N, n), by the noise in its own channel, over the Nyquist frequency."""
    return [reached(x, channel_noise(x)) for x in values.T]


def channel_noise(values: np.ndarray) -> float:
    """Standard deviation of the white noise that fills a smooth channel's (N,) highest frequencies.

    By the mean power: where periods are alike they round alike, and the noise is a few lines.
    """
    return float(np.sqrt(top_power(values).mean()))


def top_power(values: np.ndarray) -> np.ndarray:
    """(M,) power of a signal (N,) at its highest frequencies, as the variance of white noise that has it."""
    window = np.hanning(len(values))
    S = np.abs(np.fft.rfft((values - values.mean()) * window)) ** 2 / np.sum(window**2)
    return S[int(WHITE_FROM * len(S)) :]


def _course(x: np.ndarray, count: int) -> np.ndarray:
    """(N,) smooth curve with the value, second and fourth derivative that x has at both ends.

    count   samples of an end from which they are found
    """
    s, weights = np.linspace(0, 1, len(x)), _derivatives_at_the_end(count)
    unit = (count - 1) / (len(x) - 1)
    return _from_end(1 - s, unit, *(weights @ x[:count])) + _from_end(s, unit, *(weights @ x[::-1][:count]))


def _from_end(u: np.ndarray, unit: float, value: float, second: float, fourth: float) -> np.ndarray:
    """(N,) curve in u (N,) with these where u is 1, by times of a unit, and none of them where u is 0.

    Of a line and two hyperbolic sines, which stay near the end: a polynomial of the whole motion's length
    would be as large as the fourth power of what it has in units, and leave its rounding for noise.
    """
    p, q = (1 / length**2 for length in _LENGTHS)
    first, other = (fourth - q * second) / (p * (p - q)), (fourth - p * second) / (q * (q - p))
    short, long = (_sinh(u, length * unit) for length in _LENGTHS)
    return (value - first - other) * u + first * short + other * long


def _sinh(u: np.ndarray, length: float) -> np.ndarray:
    """sinh(u / length) / sinh(1 / length)."""
    return np.exp((u - 1) / length) * np.expm1(-2 * u / length) / np.expm1(-2 / length)


def _continued(x: np.ndarray, count: int) -> np.ndarray:
    """x with samples behind its end, up to a length that is quick to transform: odd about the end, beside the
    even polynomial of the derivatives there, of which no more is asked than `count` samples tell well."""
    more = int(next_fast_len(len(x) - 1) or 0) + 1 - len(x)
    if not 0 < more <= _BEYOND * count:
        return x
    u = np.arange(1, more + 1) / (count - 1)
    value, second, fourth = _derivatives_at_the_end(count) @ x[::-1][:count]
    even = value + u * u * (second / 2 + u * u * fourth / 24)
    return np.concatenate([x, 2 * even - x[-2 : -2 - more : -1]])


@lru_cache(256)
def _derivatives_at_the_end(count: int) -> np.ndarray:
    """(3, count) weights of samples that give the value, second and fourth derivative at the first of them,
    by a time that is 1 at the last: those of a polynomial that fits best."""
    degree = min(_DEGREE, count - 1)
    fitted = np.linalg.pinv(chebvander(np.linspace(-1, 1, count), degree))
    basis = [Chebyshev.basis(n) for n in range(degree + 1)]
    return np.array([[2**order * wave.deriv(order)(-1.0) for wave in basis] for order in (0, 2, 4)]) @ fitted
