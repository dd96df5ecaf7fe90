"""The steps of a log's time: rows that come twice, stamps that were rounded, jitter and missing samples."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from flexmodels.coordinate import is_motor
from pyident.logs.encoders import resolution
from pyident.logs.gaps import WIDEST_GAP, in_short_gaps, widest_gap
from pyident.logs.log import LogError

_UNEVEN = 0.01  # of one period: more is jitter, and the log is resampled
_WHOLE = 0.05  # of one period: gaps this near to whole periods are samples that were lost
_USUAL, _STEADY = 0.9, 0.25  # of the steps, which are so near to whole periods where samples can be counted
_SAME = 0.02  # of the resolution of stamps: what counts as the same step
_SMOOTHER = 0.7  # times as rough: less is no chance, and more is noise that stamps add little to
_ROUNDED = 1e-9  # of a position's range: less is of numbers, not of a motion
_LATEST = 0.1  # s that a busy computer may stamp late
_STAMPS = 9  # on either side of a long step, which tell whether it lasts
_SHORT = 100  # samples, too few to tell
_JUMPS = 8  # steps of the rarer kind: with fewer, samples may be missing


def repeated(columns: Sequence[np.ndarray]) -> np.ndarray:
    """Rows (N,) that are the row before them again, in every one of some columns (N,), time among them."""
    same = np.logical_and.reduce([(np.diff(x) == 0) | (np.isnan(x[1:]) & np.isnan(x[:-1])) for x in columns])
    return np.concatenate([[False], same])


def unrounded(time: np.ndarray) -> np.ndarray | None:
    """Even stamps (N,) where those given are such ones, rounded to more than their jitter; else None.

    Then the steps are of two sizes, whole multiples of their difference, and nowhere do the stamps leave the
    straight line by more than that.
    """
    steps = np.diff(time)
    if len(steps) < 2 * _JUMPS or not np.isfinite(time).all() or (steps < 0).any():
        return None
    low, high, mean = float(steps.min()), float(steps.max()), float(steps.mean())
    resolution = high - low
    if resolution <= _UNEVEN * mean:
        return None
    up = np.abs(steps - high) < _SAME * resolution
    down = np.abs(steps - low) < _SAME * resolution
    multiple = low / resolution
    if not (up | down).all() or abs(multiple - round(multiple)) > _SAME or min(up.sum(), down.sum()) < _JUMPS:
        return None
    count = np.arange(len(time))
    even = np.polyval(np.polyfit(count, time - time[0], 1), count) + time[0]
    return even if np.ptp(time - even) <= (1 + _SAME) * resolution else None


def usual_step(time: np.ndarray) -> float:
    """The period of stamps (N,), some of which may come twice or be rounded."""
    even = unrounded(time)
    steps = np.diff(time if even is None else even)
    return float(np.median(steps[steps != 0])) if (steps != 0).any() else 0.0


def filled(frame: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Empty cells in a column's short gaps are filled as missing rows are; and a note on each such column."""
    time = frame["time"].to_numpy(float)
    out, notes = {}, []
    for name in map(str, frame):
        values = frame[name].to_numpy(float)
        empty = in_short_gaps(time, values)
        if name != "time" and empty.any():
            there = np.isfinite(values)
            out[name] = values.copy()
            out[name][empty] = _at_times(name, time[there], values[there], time[empty])
            many = "1 sample," if empty.sum() == 1 else f"{empty.sum()} samples, first"
            said = f"{name} lacks {many} at {time[empty][0]:.6g} s"
            notes.append(f"{said}: filled in by {_how(name)}")
    return frame.assign(**out), notes


def evened(frame: pd.DataFrame, source: str) -> tuple[pd.DataFrame, list[str]]:
    """Samples at a uniform period; jittered ones are resampled by cubic splines.

    frame   its index counts the rows of the file from 0. Raises LogError.
    """
    time = frame["time"].to_numpy(float)
    if len(time) < 4 or not np.isfinite(frame.to_numpy(float)).all():
        return frame, []  # the check that follows explains it
    steps = np.diff(time)
    if (steps <= 0).any():
        raise LogError(f"{source}: {_stands_still(frame, steps)}")
    period = float(np.median(steps))
    worst = float(np.abs(steps - period).max())
    if worst <= _UNEVEN * period:
        return frame.reset_index(drop=True), []
    if (gap := widest_gap(steps, period)) is not None:
        row = int(frame.index[gap + 1]) + 1
        raise LogError(f"{source}: a gap of {steps[gap]:.3g} s at row {row}; cut the log there")
    if (sampled := _sampled_evenly(frame, time, period)) is not None:
        late = float(np.abs(time - sampled).max())
        frame, said = evened(frame.assign(time=sampled), source)
        return frame, [f"stamps jitter (up to {1e3 * late:.3g} ms), the samples do not: taken as even", *said]
    even = np.arange(time[0], time[-1] + 1e-9 * period, period)
    out = {name: _at_times(str(name), time, frame[name].to_numpy(float), even) for name in frame}
    return pd.DataFrame(out), [_resampled(time, period)]


def _sampled_evenly(frame: pd.DataFrame, time: np.ndarray, period: float) -> np.ndarray | None:
    """Even times (N,) of samples whose stamps alone jitter, by which positions are smoother; else None.

    time    (N,) the stamps;  period: the usual one of these. Samples that are lost stay so
    """
    number = _numbers(time, period)
    positions = [frame[n].to_numpy(float) for n in frame if is_motor(str(n))]
    even = np.polyval(np.polyfit(number, time - time[0], 1), number) + time[0]
    if len(time) < _SHORT or np.abs(time - even).max() > max(_LATEST, WIDEST_GAP * period):
        return None  # a clock that changes its pace
    rough = [(x, _roughness(time, x)) for x in positions]
    ratios = [_roughness(even, x) / r for x, r in rough if r > max(resolution(x), _ROUNDED * np.ptp(x))]
    return even if ratios and np.median(ratios) < _SMOOTHER else None


def _numbers(time: np.ndarray, period: float) -> np.ndarray:
    """(N,) of samples from 0 on. One is lost where stamps come later by a period from then on; a long step
    between short ones is a stamp that is late by itself.
    """
    count, off = np.arange(len(time)), time - time[0] - period * np.arange(len(time))
    lost = np.zeros(len(time))
    for k in (np.flatnonzero(np.round(np.diff(time) / period) > 1) + 1).tolist():
        before, after = off[max(k - _STAMPS, 0) : k], off[k : k + _STAMPS]
        lost[k] = max(np.round((np.median(after) - np.median(before)) / period), 0.0)
    return count + np.cumsum(lost)


def _roughness(time: np.ndarray, x: np.ndarray) -> float:
    """Usual fourth difference of what was sampled (N,) at some times (N,), put to even ones."""
    even = np.linspace(time[0], time[-1], len(time))
    return float(np.median(np.abs(np.diff(CubicSpline(time, x)(even), 4))))


def _stands_still(frame: pd.DataFrame, steps: np.ndarray) -> str:
    """What is wrong where time does not increase, and what to do."""
    at = int(np.argmax(steps <= 0))
    said = f"time does not increase at row {int(frame.index[at + 1]) + 1}"
    if steps[at] < 0:
        return f"{said}; cut the log there"
    return (
        f"{said}, which has the stamp of the row before it and other values; if the samples are evenly "
        "spaced, give rate (Hz) in the mapping instead of time, else cut the log there"
    )


def _resampled(time: np.ndarray, period: float) -> str:
    """A note: how many samples were lost, and by how much time was uneven beside that."""
    periods = np.diff(_numbers(time, period))
    lost = int(np.sum(periods - 1))
    samples = "1 sample is" if lost == 1 else f"{lost} samples are"
    off = np.abs(np.diff(time) - period * periods)
    if np.quantile(off, _USUAL) > _STEADY * period:  # of a clock so uneven, no number of samples is known
        lost, off = 0, np.abs(np.diff(time) - period)
    worst = float(off.max())
    if lost > 0 and worst < _WHOLE * period:
        return f"{samples} missing (at {1e3 * period:.4g} ms a sample): filled in by splines"
    missing = f"{samples} missing and " if lost > 0 else ""
    return f"{missing}time was uneven (up to {1e3 * worst:.3g} ms off {1e3 * period:.4g} ms): resampled"


def _at_times(name: str, time: np.ndarray, values: np.ndarray, even: np.ndarray) -> np.ndarray:
    """Commands jump, where a spline would swing: they are taken as linear, switches as held."""
    if name == "time":
        return even
    if name.endswith(".on"):
        return values[np.maximum(np.searchsorted(time, even, side="right") - 1, 0)]
    return np.interp(even, time, values) if name.endswith(".r") else CubicSpline(time, values)(even)


def _how(name: str) -> str:
    """What `_at_times` does between the samples of a signal."""
    return "what was held" if name.endswith(".on") else "lines" if name.endswith(".r") else "splines"
