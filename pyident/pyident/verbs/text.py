"""Text that reads well in a terminal and in a notebook."""

from collections.abc import Sequence
from html import escape
from io import StringIO
from math import isfinite
from shutil import get_terminal_size
from textwrap import fill

from pyident.rules.confidence import CONFIDENCE

_WIDEST = 160


class Text(str):
    """Shown as it reads, not as a quoted string."""

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self)}</pre>"


def width() -> int:
    """Columns of the terminal, 80 where there is none."""
    return min(get_terminal_size((80, 24)).columns, _WIDEST)


def wrapped(sentence: str, indent: str = "") -> str:
    """Lines of a sentence; names are not broken."""
    return fill(sentence, width(), subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def half_interval(std: float) -> str:
    """Half of a 95 % interval; where there is none, nothing is claimed."""
    return f"{CONFIDENCE * std:.2g}" if isfinite(std) else "-"


def table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], title: str = "", numbers: Sequence[int] = ()
) -> str:
    """Lines of a table. Text is wrapped between words, never within one; columns in `numbers` stand right."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    text = [column for column in range(len(heads)) if column not in numbers]
    longest = [
        max((len(word) for row in rows for word in row[c].split()), default=1) for c in range(len(heads))
    ]
    out = Table(
        box=box.SIMPLE_HEAD, title=title or None, title_justify="left", pad_edge=False, padding=(0, 1)
    )
    for c, head in enumerate(heads):
        if c in text:
            out.add_column(head, min_width=longest[c], overflow="fold")
        else:
            out.add_column(head, justify="right", no_wrap=True)
    for row in rows:
        out.add_row(*row)
    needed = sum(longest) + 3 * len(heads) + 8
    stream = StringIO()
    Console(file=stream, width=max(width(), needed), markup=False, emoji=False, highlight=False).print(out)
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines() if line.strip())
