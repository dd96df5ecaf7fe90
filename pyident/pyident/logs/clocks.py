"""Columns of several rates on the clock of the mapping's time."""

import re

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from pyident.logs.gaps import in_short_gaps
from pyident.logs.log import LogError
from pyident.logs.mapping import Mapping
from pyident.logs.steps import repeated, unrounded
from pyident.logs.turns import unwrapped, whole_turn
from pyident.logs.units import without_unit

_FEWEST = 4  # rows
_LISTED = 5  # columns in a refusal
_ANGLES = (".e", ".q", ".link", ".r")


def on_one_clock(raw: dict[str, np.ndarray], mapping: Mapping, source: str) -> tuple[pd.DataFrame, list[str]]:
    """`time` [s] and every mapped signal; those with an own clock by cubic splines, and a note on each.

    Rows that a slower clock does not reach are left out, and those that repeat the row before them; the index
    counts the rows of the file from 0. Raises LogError.
    """
    values, notes = {}, []
    for name, s in mapping.signals.items():
        x = _column(raw, s.column, source)
        if s.turn is None and name.endswith(_ANGLES) and whole_turn(x) is not None:
            notes.append(f"{s.column} jumps by whole turns; unwrap = true in the mapping of {name} joins it")
        values[name] = unwrapped(x, s.turn) * s.gain + s.offset
    if mapping.rate is not None:
        length = max((len(x) for name, x in values.items() if not mapping.signals[name].clock), default=0)
        values = {"time": np.arange(length) / mapping.rate} | values
    own = {name: s.clock for name, s in mapping.signals.items() if s.clock is not None}
    beside = {name: x for name, x in values.items() if name not in own}
    _as_long(beside, mapping, source)
    rows, beside, said = _steady(beside)
    notes += said
    time = beside["time"]
    first, last = time[0], time[-1]
    for name, clock in own.items():
        stamps = _column(raw, clock, source)
        stamps = stamps * (mapping.signals["time"].gain if mapping.rate is None else 1.0)
        column = mapping.signals[name].column
        stamps, own_values = _on_own(stamps, values[name], source, f"{clock} is no clock of {column}")
        missing = in_short_gaps(stamps, own_values)
        if missing.any():
            notes.append(f"{name} lacks {missing.sum()} of its own samples: passed over")
            stamps, own_values = stamps[~missing], own_values[~missing]
        if not np.isfinite(own_values).all():
            raise LogError(f"{source}: column {column} holds values that are not finite")
        beside[name] = CubicSpline(stamps, own_values)(np.clip(time, stamps[0], stamps[-1]))
        first, last = max(first, stamps[0]), min(last, stamps[-1])
        rate = (len(stamps) - 1) / (stamps[-1] - stamps[0])
        notes.append(f"{name} was recorded at {rate:.4g} Hz and brought to the clock of time")
    if len(time) < _FEWEST:
        rows = "1 row" if len(time) == 1 else f"{len(time)} rows"
        raise LogError(f"{source}: it has {rows}, too few for any motion; record at least some seconds")
    inside = (time >= first) & (time <= last)
    if inside.sum() < _FEWEST:
        raise LogError(f"{source}: the clocks of its columns do not overlap; check their units")
    return pd.DataFrame({name: beside[name][inside] for name in values}, index=rows[inside]), notes


def _as_long(beside: dict[str, np.ndarray], mapping: Mapping, source: str) -> None:
    """Raises LogError where a column without a clock of its own is not as long as time."""
    count = len(beside["time"])
    for name, x in beside.items():
        if len(x) != count:
            raise LogError(
                f"{source}: column {mapping.signals[name].column} has {len(x)} samples, time has {count}; "
                'name its own clock in the mapping (time = "...")'
            )


def _steady(beside: dict[str, np.ndarray]) -> tuple[np.ndarray, dict[str, np.ndarray], list[str]]:
    """Rows that are kept, the columns at these, of stamps as even as they were before rounding; and notes."""
    notes = []
    twice = repeated(list(beside.values()))
    if twice.any():
        beside = {name: x[~twice] for name, x in beside.items()}
        notes.append(f"rows that repeat the row before them, stamp and values, left out: {twice.sum()}")
    time = beside["time"]
    even = unrounded(time)
    if even is not None:
        step, coarse = (1e3 * x for x in (even[1] - even[0], np.ptp(np.diff(time))))
        beside = beside | {"time": even}
        notes.append(f"the stamps of time are rounded to {coarse:.3g} ms: taken as even, every {step:.4g} ms")
    return np.flatnonzero(~twice), beside, notes


def _on_own(stamps: np.ndarray, values: np.ndarray, source: str, wrong: str) -> tuple[np.ndarray, np.ndarray]:
    """Stamps (M,) of a column's own clock and its values (M,), repeats left out. Raises LogError."""
    if len(stamps) == len(values):
        kept = ~repeated([stamps, values])
        stamps, values = stamps[kept], values[kept]
        even = unrounded(stamps)
        stamps = stamps if even is None else even
    if len(stamps) != len(values) or len(stamps) < 4 or (np.diff(stamps) <= 0).any():
        raise LogError(f"{source}: {wrong}: it must rise and be as long")
    return stamps, values


def _column(raw: dict[str, np.ndarray], column: str, source: str) -> np.ndarray:
    bare, _ = without_unit(column)  # a file's own name may hold it, and is read without
    if column not in raw and bare not in raw:
        stem = re.split(r"[\[:.]", column)[0]
        own = [name for name in raw if not any(name.endswith(f":{other}") for other in raw)]
        near = [name for name in own if stem in name] or own
        more = " ..." if len(near) > _LISTED else ""
        raise LogError(f"{source}: there is no column {column}; there are {', '.join(near[:_LISTED])}{more}")
    return np.asarray(raw[column if column in raw else bare], dtype=float)
