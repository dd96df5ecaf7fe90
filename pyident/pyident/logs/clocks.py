"""Columns of several rates on the clock of the mapping's time."""

import re

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from pyident.logs.log import LogError
from pyident.logs.mapping import Mapping


def on_one_clock(raw: dict[str, np.ndarray], mapping: Mapping, source: str) -> tuple[pd.DataFrame, list[str]]:
    """`time` [s] and every mapped signal; those with an own clock by cubic splines, and a note on each.

    Rows that a slower clock does not reach are left out. Raises LogError.
    """
    values = {name: _column(raw, s.column, source) * s.gain + s.offset for name, s in mapping.signals.items()}
    if mapping.rate is not None:
        length = max((len(x) for name, x in values.items() if not mapping.signals[name].clock), default=0)
        values = {"time": np.arange(length) / mapping.rate} | values
    time, notes = values["time"], []
    first, last = time[0], time[-1]
    for name, s in mapping.signals.items():
        if s.clock is not None:
            own = _column(raw, s.clock, source) * (
                mapping.signals["time"].gain if mapping.rate is None else 1.0
            )
            if len(own) != len(values[name]) or len(own) < 4 or (np.diff(own) <= 0).any():
                raise LogError(f"{source}: {s.clock} is no clock of {s.column}: it must rise and be as long")
            if not np.isfinite(values[name]).all():
                raise LogError(f"{source}: column {s.column} holds values that are not finite")
            values[name] = CubicSpline(own, values[name])(np.clip(time, own[0], own[-1]))
            first, last = max(first, own[0]), min(last, own[-1])
            rate = (len(own) - 1) / (own[-1] - own[0])
            notes.append(f"{name} was recorded at {rate:.4g} Hz and brought to the clock of time")
        elif len(values[name]) != len(time):
            raise LogError(
                f"{source}: column {s.column} has {len(values[name])} samples, time has {len(time)}; name "
                "its own "
                f'clock in the mapping (time = "...")'
            )
    inside = (time >= first) & (time <= last)
    if inside.sum() < 4:
        raise LogError(f"{source}: the clocks of its columns do not overlap; check their units")
    return pd.DataFrame({name: x[inside] for name, x in values.items()}), notes


def _column(raw: dict[str, np.ndarray], column: str, source: str) -> np.ndarray:
    if column not in raw:
        stem = re.split(r"[\[:.]", column)[0]
        near = [name for name in raw if stem in name][:5] or list(raw)[:5]
        raise LogError(f"{source}: there is no column {column}; there are {', '.join(near)} ...")
    return np.asarray(raw[column], dtype=float)
