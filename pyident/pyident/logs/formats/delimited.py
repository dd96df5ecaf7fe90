"""CSV of any kind: separator, decimal sign, header, row of units and first row of numbers are found."""

import csv
import io
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pyident.logs.formats.joint_states import message_names
from pyident.logs.formats.recording import Recording, with_whole_stamps
from pyident.logs.log import LogError
from pyident.logs.units import known_unit

_LOOK = 200  # lines
_SEPARATORS = (",", ";", "\t", "|", " ")
_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*|\s*(nan|inf|-inf)\s*", re.IGNORECASE)
_COMMA = re.compile(r"\s*[-+]?(\d+,?\d*|,\d+)([eE][-+]?\d+)?\s*")
_DATE = re.compile(r"\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d.*")
_LIST = re.compile(r"\s*(?:array\(\s*(?:'\w'\s*,\s*)?)?([\[(].*[\])])\s*", re.DOTALL)  # array('d', [1.0])
_TYPE = re.compile(r",\s*dtype=\w+")
_IN_NAME = re.compile(r"^(.*?)\s*[\[(]\s*([^\[\]()]+?)\s*[\])]\s*$")


@dataclass(frozen=True)
class Layout:
    """separator, decimal sign; names and units of the columns; number of the first line of numbers."""

    separator: str
    decimal: str
    names: tuple[str, ...] | None
    units: tuple[str, ...] | None
    first: int


def read_delimited(path: Path, header: bool = True) -> Recording:
    """Every numeric column; lists in cells become `name[1]`, `name[2]` ... Raises LogError."""
    layout = layout_of(path)
    separator = r"\s+" if layout.separator == " " else layout.separator
    frame = pd.read_csv(path, sep=separator, decimal=layout.decimal, skiprows=layout.first, header=None,
                        skip_blank_lines=False, comment=None, encoding_errors="replace")  # fmt: skip
    frame = frame.dropna(axis=1, how="all").dropna(axis=0, how="all")
    found = (layout.names or message_names(frame)) if header else None
    names = found or tuple(str(i + 1) for i in range(frame.shape[1]))
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    joints = _joint_names(frame)
    for i, at in enumerate(frame.columns):
        name = names[at] if int(at) < len(names) else str(i + 1)
        for leaf, values in _cells(name, frame[at], joints):  # pyright: ignore[reportArgumentType]
            columns[leaf] = values
            if layout.units and int(at) < len(layout.units) and layout.units[at]:
                units[leaf] = layout.units[at]
    columns = with_whole_stamps(columns)
    if not columns:
        raise LogError(f"{path} holds no column of numbers")
    return Recording(columns, units, header=found is not None)


def layout_of(path: Path) -> Layout:
    """How the file is written, from its first lines. Raises LogError."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        lines = _joined([line for _, line in zip(range(_LOOK), file, strict=False)])
    best = max((_tried(lines, s) for s in _SEPARATORS), key=lambda found: found[0], default=None)
    if best is None or best[0][0] == 0:
        raise LogError(
            f"{path} has no rows of numbers; give a table of numbers with or without a line of names"
        )
    return best[1]


def _joined(lines: list[str]) -> list[str]:
    """Lines put together again that a quoted cell goes on over, as a long array of NumPy's does."""
    out: list[str] = []
    for line in lines:
        if out and out[-1].count('"') % 2:
            out[-1] = out[-1].rstrip("\r\n") + " " + line
        else:
            out.append(line)
    return out if not out or out[-1].count('"') % 2 == 0 else out[:-1] or lines


def _tried(lines: list[str], separator: str) -> tuple[tuple[float, int], Layout]:
    """The share of cells that are numbers and the number of columns; and the layout with this separator."""
    rows = [_split(line, separator) for line in lines]
    tail = [row for row in rows[len(rows) // 2 :] if row]
    decimal = "." if separator == "," else _decimal(tail)
    width = Counter(len(row) for row in tail).most_common(1)[0][0] if tail else 0
    numeric = [_numeric(row, decimal) for row in rows]
    good = [len(row) == width and share > 0.5 for row, share in zip(rows, numeric, strict=True)]
    first = next((i for i in range(len(rows)) if good[i]), len(rows))
    fitting = [share for i, share in enumerate(numeric) if good[i]]
    layout = Layout(separator, decimal, *_heads(rows[:first], width), first)
    score = float(np.mean(fitting)) * len(fitting) / max(len(rows) - first, 1) if fitting else 0.0
    return (round(score, 2) if width > 1 else 0.5 * score, width), layout


def _split(line: str, separator: str) -> list[str]:
    line = line.strip("\r\n")
    if separator == " ":
        return line.split()
    return next(csv.reader(io.StringIO(line), delimiter=separator), [])


def _decimal(rows: list[list[str]]) -> str:
    cells = [cell for row in rows for cell in row if not _LIST.fullmatch(cell)]
    commas = sum("," in cell and bool(_COMMA.fullmatch(cell)) for cell in cells)
    points = sum("." in cell and bool(_NUMBER.fullmatch(cell)) for cell in cells)
    return "," if commas > points else "."


def _numeric(row: list[str], decimal: str) -> float:
    """Share of a row's cells that are numbers, lists or dates; empty ones do not count."""
    pattern = _NUMBER if decimal == "." else _COMMA
    cells = [cell for cell in row if cell.strip()]
    return (
        sum(bool(pattern.fullmatch(c) or _LIST.fullmatch(c) or _DATE.fullmatch(c)) for c in cells)
        / len(cells)
        if cells
        else 0.0
    )


def _heads(rows: list[list[str]], width: int) -> tuple[tuple[str, ...] | None, tuple[str, ...] | None]:
    """Names and units of the columns from the lines above the numbers."""
    fitting = [[cell.strip().lstrip("#%").strip() for cell in row] for row in rows if len(row) == width]
    if not fitting:
        return None, None
    units = None
    if len(fitting) > 1 and _is_units(fitting[-1]):
        units = tuple(cell.strip("[]()") for cell in fitting.pop())
    names, inside = [], []
    for cell in fitting[-1]:
        parts = _IN_NAME.match(cell)
        unit = parts[2] if parts and known_unit(parts[2]) else ""
        names.append(parts[1] if parts and unit else cell)
        inside.append(unit)
    if len(set(names)) < len(names):
        names = [cell if names.count(n) > 1 else n for cell, n in zip(fitting[-1], names, strict=True)]
    return tuple(names), units or (tuple(inside) if any(inside) else None)


def _is_units(row: list[str]) -> bool:
    cells = [cell.strip("[]() ") for cell in row]
    return sum(c in ("", "-") or known_unit(c) is not None for c in cells) > 0.7 * len(cells) and any(cells)


def _joint_names(frame: pd.DataFrame) -> list[str]:
    """The names that every row lists in one cell, as messages of joints do; none where there are none."""
    for at in frame.columns:
        first = str(frame[at].iloc[0])
        if _LIST.fullmatch(first) and set(frame[at].astype(str)) == {first}:
            parts = _parts(first)
            if len(parts) > 1 and len(set(parts)) == len(parts) and not any(map(_NUMBER.fullmatch, parts)):
                return parts
    return []


def _parts(cell: str) -> list[str]:
    """The members of a list as Python, JSON, NumPy and spreadsheets write it."""
    found = _LIST.fullmatch(cell)
    inside = _TYPE.sub("", found[1] if found else cell)
    return [part.strip("'\"") for part in re.split(r"[\s,;\[\]()]+", inside) if part.strip("'\"")]


def _cells(name: str, column: pd.Series, joints: list[str]) -> list[tuple[str, np.ndarray]]:
    """A column's numbers; of lists one column per place, or per joint; of dates seconds; else nothing."""
    if pd.api.types.is_bool_dtype(column) or pd.api.types.is_numeric_dtype(column):
        return [(name, column.to_numpy(float))]
    text = column.astype(str).str.strip()
    if sum(bool(_LIST.fullmatch(cell)) for cell in text) > 0.9 * len(text):
        rows = [_parts(cell) for cell in text]
        if len({len(row) for row in rows}) > 1 or not all(map(_NUMBER.fullmatch, rows[0])):
            return []
        named = len(rows[0]) == len(joints)
        ends = (
            [f"{joint}.{name}" for joint in joints]
            if named
            else [f"{name}[{i + 1}]" for i in range(len(rows[0]))]
        )
        values = np.array([[float(part) for part in row] for row in rows])
        return list(zip(ends, values.T, strict=True))
    numbers = pd.to_numeric(text, errors="coerce")
    if numbers.notna().mean() > 0.5:  # pyright: ignore[reportAttributeAccessIssue]
        return [(name, numbers.to_numpy(float))]  # pyright: ignore[reportArgumentType, reportAttributeAccessIssue, reportCallIssue, reportReturnType]
    try:
        stamps = pd.to_datetime(text, errors="raise", utc=True, format="ISO8601")
    except (ValueError, TypeError):
        return []
    return [(name, (stamps - stamps.iloc[0]).dt.total_seconds().to_numpy(float))]
