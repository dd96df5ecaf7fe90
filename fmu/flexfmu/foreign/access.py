"""Variables of an instance by few calls, and inputs that move while FMPy integrates."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.model_description import ScalarVariable


class Access:
    """Set or get some variables of any type by as few calls as their types need."""

    def __init__(self, fmu: Any, verb: str, variables: Sequence[ScalarVariable]):
        calls: dict[str, list[int]] = {}
        for place, variable in enumerate(variables):
            kind = str(variable.type)
            if kind == "Enumeration":
                kind = "Integer" if isinstance(fmu, FMU2Model | FMU2Slave) else "Int64"
            calls.setdefault(kind, []).append(place)
        self._size = len(variables)
        self._calls = [
            (getattr(fmu, verb + kind), kind, places, [variables[p].valueReference for p in places])
            for kind, places in calls.items()
        ]

    def put(self, values: Sequence[float] | np.ndarray) -> None:
        for call, kind, places, references in self._calls:
            listed = [float(values[p]) for p in places]
            whole = kind not in ("Real", "Float64", "Float32")
            call(
                references, [bool(v) if kind == "Boolean" else round(v) for v in listed] if whole else listed
            )

    def values(self) -> np.ndarray:
        row = np.empty(self._size)
        for call, _, places, references in self._calls:
            row[places] = call(references)
        return row


def linear_feed(
    fmu: Any, variables: Sequence[ScalarVariable], time: np.ndarray, inputs: np.ndarray
) -> Callable[[float], None]:
    """What sets the continuous ones of the inputs (N, variables), linear between samples, at an instant."""
    moving = [i for i, v in enumerate(variables) if v.variability in (None, "continuous")]
    write = Access(fmu, "set", [variables[i] for i in moving])
    begin, period, last = float(time[0]), float(time[1] - time[0]), len(time) - 2
    times, rows = time.tolist(), inputs[:, moving].tolist()  # of few numbers a list is faster than an array

    def feed(t: float) -> None:
        if moving:
            k = min(max(int((t - begin) / period), 0), last)
            part = (t - times[k]) / (times[k + 1] - times[k])
            write.put([(1 - part) * a + part * b for a, b in zip(rows[k], rows[k + 1], strict=True)])

    return feed


def feed_at_every_instant(fmu: Any, feed: Callable[[float], None]) -> None:
    """FMPy's loop sets inputs after a step of its solver only: within it they would be held."""
    set_time = fmu.setTime

    def set_time_and_inputs(now: float) -> Any:
        status = set_time(now)
        feed(now)
        return status

    vars(fmu)["setTime"] = set_time_and_inputs
