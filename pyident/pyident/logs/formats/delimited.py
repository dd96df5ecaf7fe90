"""CSV of any kind: its layout is found, rows that are none are left out, columns become numbers."""

from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd

from pyident.logs.formats.cells import NUMBER, is_list, list_parts, numbers_of, with_points
from pyident.logs.formats.joint_states import message_names
from pyident.logs.formats.layout import Layout, layout_of, split
from pyident.logs.formats.recording import Recording
from pyident.logs.formats.table import recording_of

_WORDS = 0.1  # of a column of numbers
_TAIL = 1 << 16  # bytes of the end of a file, which hold its last line


def read_delimited(path: Path, header: bool = True) -> Recording:
    """Every numeric column; lists in cells become `name[1]`, `name[2]` ... Raises LogError."""
    layout = layout_of(path)
    frame, notes = _rows(path, layout)
    found = (layout.names or message_names(frame)) if header else None
    names = found or tuple(str(i + 1) for i in range(frame.shape[1]))
    names, again = _told_apart(names)
    notes += [*again, *([layout.odd] if layout.odd and header else [])]
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    texts: dict[str, pd.Series] = {}
    joints = _joint_names(frame)
    for i, at in enumerate(frame.columns):
        name = names[at] if int(at) < len(names) else str(i + 1)
        column = pd.Series(frame[at])
        leaves = numbers_of(name, column, joints, layout.decimal)
        columns |= leaves
        if not leaves:
            texts[name] = column
        if layout.units and int(at) < len(layout.units) and layout.units[at]:
            units |= dict.fromkeys(leaves, str(layout.units[at]))
    return recording_of(columns, texts, str(path), units, found is not None, notes)


def _told_apart(names: tuple[str, ...]) -> tuple[tuple[str, ...], list[str]]:
    """Names of which none comes twice, and a note on every one that did."""
    out: list[str] = []
    for name in names:
        count = 1 + names[: len(out)].count(name)
        out.append(name if count == 1 else f"{name} ({count})")
    return tuple(out), [_note(name, count) for name, count in Counter(names).items() if count > 1]


def _note(name: str, count: int) -> str:
    if count == 2:
        return f"column {name} is there more than once; no. 2 is called {f'{name} (2)'!r} here"
    others = f"{f'{name} (2)'!r} to {f'{name} ({count})'!r}"
    return f"column {name} is there {count} times; the others are called {others} here"


def _rows(path: Path, layout: Layout) -> tuple[pd.DataFrame, list[str]]:
    """The rows of the table, columns numbered from 0, and a note on every row that is none."""
    separator = r"\s+" if layout.separator == " " else layout.separator
    frame = pd.read_csv(path, sep=separator, decimal=layout.decimal, skiprows=layout.first, header=None,
                        skip_blank_lines=False, comment=None, encoding=layout.encoding, low_memory=False,
                        encoding_errors="replace")  # fmt: skip
    frame = frame.dropna(axis=1, how="all").dropna(axis=0, how="all")
    notes = []
    if len(frame) > 1 and _cut_off(path, layout):
        frame = frame.iloc[:-1]
        notes.append("the last row, which is incomplete, left out")
    words = _words_at_the_end(frame, layout.decimal)
    if words:
        frame = frame.iloc[:-words]
        which = "the last row, which holds" if words == 1 else f"the last {words} rows, which hold"
        notes.append(f"{which} words where numbers are above, left out")
    again = _names_again(frame, layout)
    if again.any():
        frame = frame.loc[~again]
        rows = "1 row that repeats" if again.sum() == 1 else f"{again.sum()} rows that repeat"
        notes.append(f"{rows} the line of names left out")
    return frame, notes


def _cut_off(path: Path, layout: Layout) -> bool:
    """Whether the last line has fewer cells than the lines above it."""
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - _TAIL, 0))
        end = file.read().decode(layout.encoding, errors="replace")
    lines = [line for line in end.splitlines() if line.strip()]
    if len(lines) < 2 or '"' in lines[-1] + lines[-2]:
        return False
    above, last = (len(split(line, layout.separator)) for line in lines[-2:])
    return last < layout.width <= above


def _words_at_the_end(frame: pd.DataFrame, decimal: str) -> int:
    """Rows at the end with words where numbers are above them: sums and remarks of a recorder."""
    bad = np.zeros(len(frame), bool)
    for at in frame.columns:
        if pd.api.types.is_numeric_dtype(frame[at]):
            continue
        text = with_points(frame[at].astype(str).str.strip(), decimal)
        numbers = np.asarray(pd.to_numeric(text, errors="coerce"), float)
        wrong = np.isnan(numbers) & np.asarray(frame[at].notna())
        if wrong.mean() < _WORDS:
            bad |= wrong
    return len(bad) if bad.all() else int(np.argmin(bad[::-1]))


def _names_again(frame: pd.DataFrame, layout: Layout) -> np.ndarray:
    """Rows (N,) that are the line of names, which a recorder writes when it starts again."""
    words = [at for at in frame.columns if not pd.api.types.is_numeric_dtype(frame[at])]
    words = [at for at in words if int(at) < len(layout.heads)]
    if not words:
        return np.zeros(len(frame), bool)
    same = [frame[at].astype(str).str.strip() == layout.heads[int(at)] for at in words]
    return np.logical_and.reduce(same)


def _joint_names(frame: pd.DataFrame) -> list[str]:
    """The names that every row lists in one cell, as messages of joints do; none where there are none."""
    for at in frame.columns:
        first = str(frame[at].iloc[0])
        if is_list(first) and set(frame[at].astype(str)) == {first}:
            parts = list_parts(first)
            if len(parts) > 1 and len(set(parts)) == len(parts) and not any(map(NUMBER.fullmatch, parts)):
                return parts
    return []
