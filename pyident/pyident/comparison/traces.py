"""One equation along one log: measured, modelled, and the residual inside what replicas leave there.

Differences amplify noise with the square of the frequency, so that the bare residual of an acceleration hides
what physics leaves in it. It is shown below the frequency up to which it stands above its floor, data and
replicas alike.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from pyident.comparison.bins import Bin
from pyident.comparison.model_against_replicas import Part
from pyident.conditioning.reversals.rest import stretches
from pyident.logs.log import LogError
from pyident.regression.spectrum import Floor
from pyident.rules.bins import BINS
from pyident.rules.rules import RULES


@dataclass(frozen=True)
class Trace:
    """N samples of one equation [unit: N m or N] on one log.

    time [s]; position and speed of the joint's motor [rad or m, per s]
    deformation   of the joint about its axis [rad], None where it is rigid
    measured   the right-hand side, motor torque, or zero for a deformation;  modelled: Φ p
    residual   measured less modelled, below `cutoff` [Hz];  low, high: where 5 to 95 % of such replicas' lie
    used       whether the sample counts (dry friction is not known at reversals)
    band       from and to [Hz], where only these frequencies are shown; None: all below `cutoff`
    """

    log: str
    coordinate: str
    time: np.ndarray
    position: np.ndarray
    speed: np.ndarray
    deformation: np.ndarray | None
    measured: np.ndarray
    modelled: np.ndarray
    residual: np.ndarray
    low: np.ndarray
    high: np.ndarray
    used: np.ndarray
    cutoff: float
    band: tuple[float, float] | None = None

    def passed(self, values: np.ndarray) -> np.ndarray:
        """(N,) those frequencies of other values of this equation that are shown of its residual."""
        period = float(self.time[1] - self.time[0])
        if self.band is not None:
            return band_passed(values * self.used, period, self.band)
        return low_passed(values, period, self.cutoff)


@dataclass(frozen=True)
class Bump:
    """A stretch of time in which the residual leaves the ribbon. share: of the log's energy beyond it."""

    start: float
    stop: float
    over_floor: float
    share: float


def traces(
    log: str,
    coordinates: Sequence[str],
    data: Part,
    replicas: Sequence[Part],
    bins: Sequence[Bin],
    joints: Sequence[int],
    twists: Sequence[int | None],
) -> tuple[Trace, ...]:
    """A trace per coordinate. joints, twists: positions in q of the motor and twist of each's joint."""
    listed = []
    for c, coordinate in enumerate(coordinates):
        cutoff = _cutoff([b for b in bins if b.coordinate == coordinate and b.kind == "frequency"])
        used = data.part.use[:, c] > 0
        residual = low_passed(data.residual[:, c], data.period, cutoff)
        others = [low_passed(p.residual[:, c], p.period, cutoff) for p in replicas]
        low, high = _ribbon(others, len(residual), data.period)
        measured = data.part.target[:, c]
        motion, twist = data.part.motion, twists[c]
        listed.append(
            Trace(
                log=log,
                coordinate=coordinate,
                time=data.time[-1] - data.period * np.arange(len(residual), dtype=float)[::-1],
                position=motion.q[:, joints[c]],
                speed=motion.dq[:, joints[c]],
                deformation=None if twist is None else motion.q[:, twist],
                measured=measured,
                modelled=measured - data.residual[:, c],
                residual=residual,
                low=low,
                high=high,
                used=used,
                cutoff=cutoff,
            )
        )
    return tuple(listed)


def bumps(trace: Trace) -> list[Bump]:
    """Where the residual leaves the ribbon, the largest first."""
    period = float(trace.time[1] - trace.time[0])
    width = max(int(BINS.window / period), 1)
    energy = _moving_mean(trace.residual**2, width)
    level = np.maximum(_moving_mean(np.maximum(trace.high, -trace.low) ** 2, width), 1e-300)
    outside = energy > BINS.leaves**2 * level
    beyond = np.maximum(energy - level, 0.0)
    total = max(float(beyond.sum()), 1e-300)
    found = []
    for start, stop in _split(energy, stretches(outside)):
        at = slice(start, stop)
        ratio = float(np.sqrt(np.max(energy[at] / level[at])))
        share = float(beyond[at].sum()) / total
        found.append(Bump(float(trace.time[start]), float(trace.time[stop - 1]), ratio, share))
    return sorted(found, key=lambda bump: -bump.share)[: BINS.most_bumps]


def _split(energy: np.ndarray, stretches: np.ndarray) -> Iterator[tuple[int, int]]:
    """The stretches, each cut where its energy falls to half of the humps on both sides."""
    from scipy.signal import find_peaks

    for start, stop in stretches:
        valleys, _ = find_peaks(-np.log(energy[start:stop] + 1e-300), prominence=BINS.valley)
        yield from pairwise([start, *(start + valleys), stop])


def _cutoff(bands: Sequence[Bin]) -> float:
    """The upper edge of the highest band that stands above its floor."""
    standing = [b.high for b in bands if b.ratio > RULES.comparison.matters]
    return max([BINS.least_cutoff, *standing])


def low_passed(values: np.ndarray, period: float, cutoff: float) -> np.ndarray:
    """(N,) below `cutoff` [Hz], without delay."""
    from scipy.signal import butter, sosfiltfilt

    relative = 2 * cutoff * period
    if relative >= 0.9 or len(values) < 64:
        return values
    return np.asarray(sosfiltfilt(butter(2, relative, output="sos"), values))


def in_band(trace: Trace, level: Floor, row: int, band: tuple[float, float]) -> Trace:
    """The same equation at the frequencies of a band [Hz] alone; row: of the coordinate in the floor.

    Raises LogError for a band without any.
    """
    period = float(trace.time[1] - trace.time[0])
    inside = (level.frequencies >= band[0]) & (level.frequencies <= band[1])
    if np.count_nonzero(inside) < 2:
        raise LogError(
            f"{trace.log}: no frequencies from {band[0]:g} to {band[1]:g} Hz; the equations hold up to "
            f"{level.frequencies[-1]:.3g} Hz"
        )
    square = 2 * period * float(np.trapezoid(level.rms[row][inside] ** 2, level.frequencies[inside]))
    edge = np.full(len(trace.time), BINS.ribbon * np.sqrt(square))
    shown = replace(trace, low=-edge, high=edge, band=band)
    return replace(shown, residual=shown.passed(trace.measured - trace.modelled))


def band_passed(values: np.ndarray, period: float, band: tuple[float, float]) -> np.ndarray:
    """(N,) of the lines of the spectrum between two frequencies [Hz], as a floor counts them."""
    length = int(next_fast_len(len(values), real=True))  # pyright: ignore[reportArgumentType]
    frequencies = np.arange(length // 2 + 1) / (length * period)
    lines = np.asarray(rfft(values, length)) * ((frequencies >= band[0]) & (frequencies <= band[1]))
    return np.asarray(irfft(lines, length))[: len(values)]


def _ribbon(replicas: Sequence[np.ndarray], samples: int, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Where 5 to 95 % of such replicas lie around each sample, (samples,) twice.

    By mean and deviation over a window: percentiles of six replicas hold 70 % of such residuals, not 90.
    """
    from scipy.ndimage import uniform_filter1d

    stacked = np.stack([r[:samples] for r in replicas])
    width = max(int(BINS.window / period), 1)
    middle = uniform_filter1d(stacked.mean(axis=0), width)
    half = BINS.ribbon * np.sqrt(np.maximum(uniform_filter1d(stacked.var(axis=0, ddof=1), width), 0.0))
    return middle - half, middle + half


def _moving_mean(values: np.ndarray, width: int) -> np.ndarray:
    from scipy.ndimage import uniform_filter1d

    return np.maximum(uniform_filter1d(values, width, mode="nearest"), 0.0)
