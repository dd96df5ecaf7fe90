"""Tables in which the rows of several sources alternate: what is filled in the same rows has one clock."""

import re
from collections import defaultdict
from collections.abc import Mapping

import numpy as np

TIME = re.compile(r"time|stamp|zeit|^_*t$", re.IGNORECASE)
_FILLED = 0.9  # of the rows: a column with more has gaps, and no clock of its own
_LEAST = 4  # rows of a source
_RAGGED = 5  # times the usual distance of filled rows: a longer one is a gap


def with_own_clocks(columns: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Columns (N,) without their empty rows, and column -> its clock; unchanged where none alternate.

    The clock of a source is the table's in its rows, called `CLOCK of COLUMN` by the source's first column.
    Where but for clocks no column is filled everywhere, the longest source keeps the clock's own name.
    """
    filled = {name: np.isfinite(x) for name, x in columns.items()}
    whole = [name for name, rows in filled.items() if rows.all()]
    rising = [name for name in whole if _rises(columns[name])]
    groups: dict[bytes, list[str]] = defaultdict(list)
    for name, rows in filled.items():
        if name not in whole:
            groups[rows.tobytes()].append(name)
    alone = len(rising) == len(whole)
    if not rising or not groups or not _alternate([filled[names[0]] for names in groups.values()], alone):
        return dict(columns), {}
    clock = next((name for name in rising if TIME.search(name)), rising[0])
    sources = sorted(groups.values(), key=lambda names: -int(filled[names[0]].sum()))
    main = [*whole, *sources.pop(0)] if alone else whole
    out = {name: columns[name][filled[main[-1]]] for name in main}
    clocks: dict[str, str] = {}
    for names in sources:
        own, rows = f"{clock} of {names[0]}", filled[names[0]]
        out |= {own: columns[clock][rows]} | {name: columns[name][rows] for name in names}
        clocks |= dict.fromkeys(names, own)
    return {name: out[name] for name in (*columns, *out)}, clocks


def _alternate(masks: list[np.ndarray], alone: bool) -> bool:
    """Whether the columns' rows are those of sources of their own, and not of one with values missing.

    masks   rows (N,) that are filled, of every kind of column that is not filled everywhere
    alone   whether but for clocks no column is filled everywhere
    """
    if any(mask.sum() < _LEAST or not _regular(mask) for mask in masks):
        return False
    if alone:
        *slower, _ = sorted(mask.mean() for mask in masks)
        return len(masks) > 1 and max(slower) < _FILLED and bool(np.logical_or.reduce(masks).all())
    return all(mask.mean() < _FILLED for mask in masks)


def _regular(mask: np.ndarray) -> bool:
    steps = np.diff(np.flatnonzero(mask))
    return bool(steps.max() <= _RAGGED * np.median(steps))


def _rises(x: np.ndarray) -> bool:
    steps = np.diff(x)
    return len(x) > 1 and bool((steps >= 0).all() and steps.max() > 0)
