"""Tables that keep every character, however narrow the terminal."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest

from pyident.verbs.text import width

_GAP = "  "  # between columns
_RULE = "─"
_BREAK = re.compile(r"(?<![=±])\s+(?![=±])")  # between words, but not within `name = value ± spread`


@dataclass(frozen=True)
class _Column:
    """Head and cells of one column; numbers stand right and keep each cell on one line."""

    head: str
    cells: tuple[str, ...]
    number: bool

    @property
    def least(self) -> int:
        """Characters of the longest part that must not be broken."""
        words = [w for cell in self.cells for w in ([cell] if self.number else cell.split())]
        return max(map(_length, self.head.split() + words), default=0)

    @property
    def widest(self) -> int:
        """Characters of the longest line where nothing is wrapped."""
        return max(_length(line) for text in (self.head, *self.cells) for line in text.split("\n"))

    def lines(self, text: str, columns: int) -> list[str]:
        """The head or a cell as lines that are all as wide as the column."""
        lines = [text] if text in self.cells and self.number else _folded(text, columns)
        spaces = [" " * (columns - _length(line)) for line in lines]
        return [s + line if self.number else line + s for line, s in zip(lines, spaces, strict=True)]


def table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], title: str = "", numbers: Sequence[int] = ()
) -> str:
    """Lines of a table; columns in `numbers` stand right.

    Text is wrapped between words, never within one. Where the words do not fit the terminal side by side, it
    becomes several tables below each other, each with the first column, or a block per row.
    """
    columns = [_Column(h, tuple(row[c].strip() for row in rows), c in numbers) for c, h in enumerate(heads)]
    bands = _bands(columns, width())
    parts = ["\n".join(_side_by_side(band, width())) for band in bands] or ["\n".join(_blocks(columns))]
    return (f"{title}\n" if title else "") + "\n\n".join(parts)


def _bands(columns: Sequence[_Column], space: int) -> list[list[_Column]]:
    """The columns as tables that fit, the first column in each; nothing where that cannot be."""
    first, *others = columns
    bands = [[first]]
    for column in others:
        if _needed([*bands[-1], column]) > space:
            bands.append([first])
        bands[-1].append(column)
    named = len(bands) == 1 or not first.number
    return bands if named and all(_needed(band) <= space for band in bands) else []


def _needed(columns: Sequence[_Column]) -> int:
    return sum(c.least for c in columns) + len(_GAP) * (len(columns) - 1)


def _side_by_side(columns: Sequence[_Column], space: int) -> list[str]:
    gaps = len(_GAP) * (len(columns) - 1)
    widths = _widths(columns, space - gaps)
    rows = [
        list(_row([c.lines(text, w) for c, text, w in zip(columns, row, widths, strict=True)]))
        for row in zip(*(c.cells for c in columns), strict=True)
    ]
    lines = list(_row([c.lines(c.head, w) for c, w in zip(columns, widths, strict=True)]))
    lines.append(_RULE * (sum(widths) + gaps))
    apart = 2 * sum(len(row) > 1 for row in rows) > len(rows)  # where most rows are tall
    for i, row in enumerate(rows):
        lines += ["", *row] if apart and i else row
    return lines


def _widths(columns: Sequence[_Column], space: int) -> list[int]:
    """Characters per column: what it asks for, but for those that ask the most as many as are left."""

    def up_to(most: int) -> list[int]:
        return [min(c.widest, max(c.least, most)) for c in columns]

    low, high = 0, max(c.widest for c in columns)
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if sum(up_to(middle)) <= space else (low, middle - 1)
    return up_to(low)


def _row(cells: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines of a row, of cells' lines that are all as wide as their column."""
    blanks = [" " * _length(lines[0]) for lines in cells]
    for line in zip_longest(*cells):
        yield _GAP.join(blank if x is None else x for x, blank in zip(line, blanks, strict=True)).rstrip()


def _blocks(columns: Sequence[_Column]) -> list[str]:
    """Every cell behind its head, or under it where that is too long; a blank line between rows."""
    lines = []
    for row in zip(*(c.cells for c in columns), strict=True):
        for column, text in zip(columns, row, strict=True):
            head = f"{column.head}: " if column.head and text else ""
            if "\n" not in text and _length(head + text) <= width():
                lines += [head + text] if text else []
                continue
            under = [text] if column.number else _folded(text, width() - len(_GAP))
            lines += [head.rstrip(), *(_GAP + line for line in under)]
        lines.append("")
    return lines[:-1]


def _folded(text: str, columns: int) -> list[str]:
    """Lines of so many characters, more only for a longer word; a value stays with its name if it can."""
    lines = []
    for part in text.split("\n"):
        line = ""
        for piece in _BREAK.split(part.strip()):
            whole = _length(piece) <= columns
            for word in [piece] if whole else piece.split():
                if line and _length(line) + 1 + _length(word) > columns:
                    lines.append(line)
                    line = word
                else:
                    line = f"{line} {word}" if line else word
        lines.append(line)
    return lines


def _length(text: str) -> int:
    """Columns of the terminal that it takes; a Chinese character takes two."""
    from rich.cells import cell_len

    return cell_len(text)
