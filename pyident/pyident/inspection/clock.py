"""Which column of a recording is its clock, in which unit, and why one that is called a time is none."""

import re
from collections import Counter
from dataclasses import replace

import numpy as np

from pyident.inspection.channel import Channel
from pyident.inspection.words import Meaning, meaning
from pyident.logs.formats.recording import Recording
from pyident.logs.gaps import widest_gap
from pyident.logs.steps import repeated, usual_step
from pyident.logs.units import FACTORS

_MOVES = 0.02  # of a clock's rows, at least, that are later than those before
_OFTEN = 0.01  # of the rows: repeats of which clocks and rates have to know
_EVEN = 0.2  # of the median step: a clock's steps
_TIMES = {"s": (2e-5, 0.15), "ms": (0.15, 150.0), "us": (150.0, 1.5e5), "ns": (1.5e5, 1e9)}  # steps
_STAMPED = re.compile(r"header\W?stamp", re.IGNORECASE)


def grows_evenly(x: np.ndarray) -> bool:
    """Whether a column (N,) could be a clock."""
    steps = np.diff(x)
    if len(steps) < 3 or not np.isfinite(steps).all() or (steps <= 0).any():
        return False
    middle = float(np.median(steps))
    return bool(np.mean(np.abs(steps - middle) < max(_EVEN * middle, 1e-12)) > 0.8)


def no_clock(channel: Channel) -> str:
    """Why a column that is called a time is none; empty for other columns."""
    if meaning(channel.column).signal != "time":
        return ""
    x = np.asarray(channel.values, float)
    steps = np.diff(x)
    if not np.isfinite(x).all():
        return f"{channel.column} holds no number in row {int(np.argmin(np.isfinite(x))) + 1}"
    if (steps < 0).any():
        i = int(np.argmax(steps < 0))
        return f"{channel.column} goes back from {x[i]:.10g} to {x[i + 1]:.10g} at row {i + 2}"
    if np.mean(steps > 0) <= _MOVES:
        times = "one time" if np.ptp(x) == 0 else f"{len(np.unique(x))} times"
        return f"{channel.column} holds {times} in {len(x)} rows, as if digits were cut off"
    return f"{channel.column} stands still or jumps"


def starts_again(channel: Channel) -> str:
    """At which rows a column that is called a time starts again, and what to do; empty where it does not."""
    x = np.asarray(channel.values, float)
    steps = np.diff(x)
    falls = np.flatnonzero(steps < 0)
    if meaning(channel.column).signal != "time" or not len(falls) or not np.isfinite(x).all():
        return ""
    if not all(_grows(part) for part in np.split(x, falls + 1)):
        return ""
    rows = f"row {falls[0] + 2}" if len(falls) == 1 else f"rows {', '.join(str(i + 2) for i in falls)}"
    return (
        f"{channel.column} starts again at {rows}: these are {len(falls) + 1} recordings in one file; cut it "
        "there"
    )


def _grows(x: np.ndarray) -> bool:
    """Whether it never falls: rows may come twice, and stamps may be coarse, but not for ever the same."""
    steps = np.diff(x)
    least = max(2, _MOVES * len(steps))
    return len(x) > 3 and bool(np.isfinite(x).all() and (steps >= 0).all() and (steps > 0).sum() > least)


def time_column(recording: Recording, said: dict[str, Meaning]) -> str | None:
    """The column of time; None: there is none. said: what the names of the columns mean."""
    own = set(recording.clocks.values())
    whole = {name: x for name, x in recording.columns.items() if len(x) == _longest(recording)}
    able = [name for name, x in whole.items() if grows_evenly(x)]
    named = [name for name in able if said[name].signal == "time"]
    if not named and recording.header:  # a bus answers when it can
        named = [name for name, x in whole.items() if said[name].signal == "time" and _grows(x)]
    named.sort(key=lambda name: _STAMPED.search(name) is None)  # when it was measured, not when it arrived
    if named:
        return next((name for name in named if name not in own or len(named) == 1), named[0])
    times = Counter(whole[name].tobytes() for name in able)
    if (twin := next((n for n in able if times[whole[n].tobytes()] > 1), None)) is not None:
        return twin  # each variable of a MAT file has the time with it
    counts = [n for n in able if said[n].signal == "other"]
    rest = [n for n in able if n not in counts]
    return rest[0] if rest and (not recording.header or said[rest[0]].signal == "unknown") else None


def without_repeats(recording: Recording) -> tuple[Recording, list[str]]:
    """Without the rows that repeat the row before them, stamp and values, as an import leaves them out.

    Where no column counts the time, they stay: a recorder that was faster than what it recorded; and a note.
    """
    columns = recording.columns
    if recording.clocks or len({len(x) for x in columns.values()}) != 1:
        return recording, []
    twice = repeated(list(columns.values()))
    if np.mean(twice) < _OFTEN:
        return recording, []
    left = {name: x[~twice] for name, x in columns.items()}
    if any(grows_evenly(x) for x in left.values()):
        return replace(recording, columns=left), []
    said = (
        f"{twice.sum()} of {len(twice)} rows repeat the row before them: the recorder was faster than what "
    )
    return recording, [f"{said}it recorded; leave them out, and give the rate of what is left"]


def same_as(name: str | None, recording: Recording) -> set[str]:
    """The columns that hold what one of them does, itself among them."""
    if name is None:
        return set()
    x = recording.columns[name]
    return {other for other, y in recording.columns.items() if np.array_equal(x, y)}


def _longest(recording: Recording) -> int:
    return max(len(x) for x in recording.columns.values())


def rate(recording: Recording, name: str, clock: str | None) -> float:
    """Samples of a column per unit of its own clock, or of the recording's; NaN without one of its length."""
    own = name if name in recording.clocks.values() else recording.clocks.get(name, clock)
    if own is None or len(recording.columns[own]) != len(recording.columns[name]):
        return float("nan")
    step = usual_step(np.asarray(recording.columns[own], float))
    return 1 / step if step > 0 else float("nan")


def gap(time: Channel) -> tuple[str, ...]:
    """A note where the time has a gap that an import would not fill."""
    steps = np.diff(np.asarray(time.values, float))
    if (i := widest_gap(steps, usual_step(time.values))) is None:
        return ()
    seconds = FACTORS[time.unit or "s"] * steps[i]
    return (f"{time.column} has a gap of {seconds:.3g} s at row {i + 2}: cut the log there",)


def time_unit(channel: Channel) -> Channel:
    """s, ms, µs or ns by its steps; steps of one may be numbers of samples."""
    step = usual_step(channel.values)
    if channel.unit is not None:
        return replace(channel, sure=True)
    unit = next((unit for unit, (low, high) in _TIMES.items() if low <= step < high), None)
    counted = step == 1 and bool((channel.values == np.round(channel.values)).all())
    if unit is None or counted:
        ask = "it counts samples or milliseconds" if counted else f"its steps are {step:.3g}"
        return replace(channel, unit=unit, doubt=f"what is the unit of time? {ask}")
    seconds = step * FACTORS[unit]
    return replace(channel, unit=unit, sure=True, why=(*channel.why, f"steps of {1e3 * seconds:.4g} ms"))
