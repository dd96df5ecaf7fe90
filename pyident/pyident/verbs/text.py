"""Text that reads well in a terminal and in a notebook."""

from html import escape
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


def finite(value: float) -> float | None:
    """A number as JSON has it: none where it is not finite."""
    return float(value) if isfinite(value) else None
