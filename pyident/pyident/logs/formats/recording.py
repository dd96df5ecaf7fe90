"""What a file holds, whatever its format: numeric columns by name, their units and their clocks."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Recording:
    """columns: name -> numbers, of one length or of several; units: as the file itself gives them.

    clocks   column -> the column that holds its time stamps, where columns have clocks of their own
    header   whether the columns have names of their own; without, they are called "1", "2", ...
    notes    rows that were left out
    texts    columns that hold words, which are left out
    """

    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str] = field(default_factory=dict)
    clocks: Mapping[str, str] = field(default_factory=dict)
    header: bool = True
    notes: tuple[str, ...] = ()
    texts: tuple[str, ...] = ()


_SECONDS = re.compile(r"(.*?)[._/]?secs?", re.IGNORECASE)
_NANOSECONDS = re.compile(r"(.*?)[._/]?(?:nano|(?<!i)n)secs?", re.IGNORECASE)  # but InSec


def with_whole_stamps(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Stamps in two columns, seconds and nanoseconds (stamp.sec, stamp.nanosec), as one [s] from 0 on."""
    parts = {found[1]: name for name in columns if (found := _NANOSECONDS.fullmatch(name))}
    out: dict[str, np.ndarray] = {}
    for name, x in columns.items():
        found = None if name in parts.values() else _SECONDS.fullmatch(name)
        if found and found[1] in parts:
            out[found[1] or "time"] = x - x[0] + 1e-9 * columns[parts[found[1]]]
        elif not (name in parts.values() and _whole(name, columns)):
            out[name] = x
    return out


def _whole(name: str, columns: Mapping[str, np.ndarray]) -> bool:
    """Whether the seconds of these nanoseconds are there, too."""
    place = _NANOSECONDS.fullmatch(name)
    others = (_SECONDS.fullmatch(c) for c in columns if not _NANOSECONDS.fullmatch(c))
    return any(found and place and found[1] == place[1] for found in others)


def leaves(name: str, value: Any) -> Iterator[tuple[str, np.ndarray]]:
    """Vectors of a structured value: `a`, `a.b` of a struct, `a[2]` of a matrix, whose long side is time.

    Of an array of structs each by its label, as Simulink gives signals (`signals.q.values`), or by its place.
    """
    if isinstance(value, np.ndarray) and value.dtype.names and value.ndim == 0:
        for part in value.dtype.names:
            yield from leaves(f"{name}.{part}", value[part].item())
    elif isinstance(value, np.ndarray) and value.dtype.names:
        for part, one in zip(_places(value.ravel()), value.ravel(), strict=True):
            yield from leaves(f"{name}{part}", np.asarray(one, value.dtype))
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub":
        if value.ndim == 1:
            yield name, value
        elif value.ndim == 2:
            rows = value if value.shape[0] < value.shape[1] else value.T
            if len(rows) == 1:
                yield name, rows[0]
            else:
                yield from ((f"{name}[{i + 1}]", row) for i, row in enumerate(rows))


def _places(structs: np.ndarray) -> list[str]:
    """What tells the structs of an array apart: their labels, where all have one, else their numbers."""
    said = structs["label"] if "label" in (structs.dtype.names or ()) else []
    labels = [str(label).strip() for label in said if isinstance(label, str)]
    if len(set(labels) - {""}) == len(structs):
        return [f".{label}" for label in labels]
    return [f"({i})" for i in range(1, len(structs) + 1)]
