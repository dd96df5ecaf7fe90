"""How a table of text is written: encoding, separator, decimal sign, names, units, first row of numbers."""

import codecs
import csv
import io
from collections import Counter
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from pyident.logs.formats.cells import COMMA, NUMBER, is_list, is_stamp
from pyident.logs.log import LogError
from pyident.logs.units import known_unit, without_unit

_LOOK = 200  # lines
_HEAD = 1 << 18  # bytes
_MARKS = ("#", "##", "%", "//", ";", "!")
_INDEX = "index"
_COUNTS = f"the first column, which counts the rows and has no name, is called {_INDEX}"
_SCOPE = {"name", "data-type"}  # labels of lines above the numbers, as TwinCAT Scope writes them
_SEPARATORS = (",", ";", "\t", "|", " ")


@dataclass(frozen=True)
class Layout:
    """separator, decimal sign; names and units of the columns; number of the first line of numbers.

    heads   the cells of the line of names as they stand in the file;  width: columns of most rows
    odd     a note where the line of names has another number of cells than the rows
    """

    separator: str
    decimal: str
    names: tuple[str, ...] | None
    units: tuple[str, ...] | None
    heads: tuple[str, ...]
    first: int
    width: int
    odd: str = ""
    encoding: str = "utf-8-sig"


def layout_of(path: Path) -> Layout:
    """How the file is written, from its first lines. Raises LogError."""
    encoding = encoding_of(path)
    with path.open(encoding=encoding, errors="replace") as file:
        lines = _joined([line for _, line in zip(range(_LOOK), file, strict=False)])
    best = max((_tried(lines, s) for s in _SEPARATORS), key=lambda found: found[0], default=None)
    if best is None or best[0][0] == 0:
        raise LogError(
            f"{path} has no rows of numbers; give a table of numbers with or without a line of names"
        )
    return replace(best[1], encoding=encoding)


def encoding_of(path: Path) -> str:
    """UTF-8 where the head of the file is that, UTF-16 by its mark, else the code page of Windows."""
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"


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
    rows = [split(line, separator) for line in lines]
    tail = [row for row in rows[len(rows) // 2 :] if row]
    decimal = "." if separator == "," else _decimal(tail)
    width = Counter(len(row) for row in tail).most_common(1)[0][0] if tail else 0
    numeric = [_numeric(row, decimal) for row in rows]
    good = [len(row) == width and share > 0.5 for row, share in zip(rows, numeric, strict=True)]
    if all(_is_number(row[0], decimal) for row in tail if len(row) == width):  # SampleTime[ms];2;2 is none
        good = [fits and _is_number(row[0], decimal) for fits, row in zip(good, rows, strict=True)]
    first = next((i for i in range(len(rows)) if good[i]), len(rows))
    fitting = [share for i, share in enumerate(numeric) if good[i]]
    above, odd = _fitted(rows[:first], rows[first:], width)
    names, units, heads = _heads(above, width)
    if names and heads and not heads[0] and _counts([row[0] for row in rows[first:] if len(row) == width]):
        names, odd = (_INDEX, *names[1:]), odd or _COUNTS
    layout = Layout(separator, decimal, names, units, heads, first, width, odd)
    score = float(np.mean(fitting)) * len(fitting) / max(len(rows) - first, 1) if fitting else 0.0
    return (round(score, 2) if width > 1 else 0.5 * score, width), layout


def split(line: str, separator: str) -> list[str]:
    """The cells of a line."""
    line = line.strip("\r\n")
    if separator == " ":
        return line.split()
    return next(csv.reader(io.StringIO(line), delimiter=separator), [])


def _decimal(rows: list[list[str]]) -> str:
    cells = [cell for row in rows for cell in row if not is_list(cell)]
    commas = sum("," in cell and bool(COMMA.fullmatch(cell)) for cell in cells)
    points = sum("." in cell and bool(NUMBER.fullmatch(cell)) for cell in cells)
    return "," if commas > points else "."


def _numeric(row: list[str], decimal: str) -> float:
    """Share of a row's cells that are numbers, lists or dates; empty ones do not count."""
    pattern = NUMBER if decimal == "." else COMMA
    cells = [cell for cell in row if cell.strip()]
    numbers = sum(bool(pattern.fullmatch(c) or is_list(c) or is_stamp(c)) for c in cells)
    return numbers / len(cells) if cells else 0.0


def _is_number(cell: str, decimal: str) -> bool:
    return bool((NUMBER if decimal == "." else COMMA).fullmatch(cell) or is_stamp(cell))


def _fitted(above: list[list[str]], below: list[list[str]], width: int) -> tuple[list[list[str]], str]:
    """Lines above the numbers, of as many cells as these where that is sure, and a note where it is not so.

    A comment mark that stands alone is no name. A first column that counts the rows may have none.
    """
    bare = [row[1:] if len(row) > width and row[0].strip() in _MARKS else row for row in above]
    bare = [row[:width] if len(row) > width and not any(row[width:]) else row for row in bare]
    rows = [row for row in bare if any(cell.strip() for cell in row)]
    if not rows or len(rows[-1]) < 2 or any(len(row) == width for row in rows):
        return bare, ""
    count = len(rows[-1])
    names = [row for row in rows if len(row) == count]
    whole = [row for row in below if len(row) == width]
    if count == width - 1 and not any(row[-1].strip() for row in whole):
        return [[*row, ""] for row in names], ""
    if count == width - 1 and _counts([row[0] for row in whole]):
        return [["" if _is_units(row) else _INDEX, *row] for row in names], _COUNTS
    numbers = sum(bool(NUMBER.fullmatch(cell)) for cell in rows[-1])
    said = f"there are {count} names above rows of {width} cells: none is used; give as many names as cells"
    return bare, said if 2 * numbers < count else ""


def _counts(cells: list[str]) -> bool:
    """Whether cells count rows, one by one."""
    numbers = [int(cell) for cell in cells if cell.strip().isdigit()]
    return 1 < len(cells) == len(numbers) and all(b == a + 1 for a, b in pairwise(numbers))


def _heads(
    rows: list[list[str]], width: int
) -> tuple[tuple[str, ...] | None, tuple[str, ...] | None, tuple[str, ...]]:
    """Names and units of the columns from the lines above the numbers, and the line of names as it is."""
    fitting = [[cell.strip() for cell in row] for row in rows if len(row) == width]
    if not fitting:
        return None, None, ()
    if pairs := next(filter(None, map(_of_pairs, fitting)), None):
        return pairs, None, ()
    labelled = {row[0].lower(): row for row in fitting}
    if labelled.keys() >= _SCOPE:
        return _of_scope(labelled)
    units = None
    if len(fitting) > 1 and _is_units(fitting[-1]):
        units = tuple(cell.lstrip("#%").strip("[]() ") for cell in fitting.pop())
    heads = [cell.lstrip("#%").strip() or str(i) for i, cell in enumerate(fitting[-1], start=1)]
    names, inside = ([without_unit(cell)[part] for cell in heads] for part in (0, 1))
    if len(set(names)) < len(names):
        names = [cell if names.count(n) > 1 else n for cell, n in zip(heads, names, strict=True)]
    return tuple(names), units or (tuple(inside) if any(inside) else None), tuple(fitting[-1])


def _of_scope(
    labelled: dict[str, list[str]],
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Names and units of columns behind one of time [ms], from lines that begin with what they are of."""
    row = labelled["name"]
    units = [unit.partition("(")[0].strip() for unit in labelled.get("unit", [""] * len(row))[1:]]
    return ("time", *row[1:]), ("ms", *units), tuple(row)


def _of_pairs(row: list[str]) -> tuple[str, ...] | None:
    """Names of columns that come in twos, a time and a value, from a line `Name, q1, Name, q2` above them."""
    said, names = set(row[::2]), row[1::2]
    if len(row) < 4 or len(row) % 2 or said != {"Name"} or len(set(names) - {""}) < len(names):
        return None
    return tuple(name for value in names for name in (f"{value}.time", value))


def _is_units(row: list[str]) -> bool:
    """Whether the line below the names has units: mostly known ones, or every cell in brackets."""
    cells = [cell.strip("#[]() ") for cell in row]
    known = [c in ("", "-", "1") or known_unit(c) is not None for c in cells]
    bracketed = all(cell.strip()[:1] in ("[", "(") and cell.strip()[-1:] in ("]", ")") for cell in row)
    return any(cells) and (bracketed or sum(known) > 0.7 * len(cells))
