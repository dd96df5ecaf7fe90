"""Docstrings as this project writes them, for autodoc: paragraphs, and tables of `name   what it is`."""

import re
from collections.abc import Iterator
from typing import Any

_ENTRY = re.compile(r"^(?P<names>\S(?:.*?\S)?)\s{2,}(?P<text>\S.*)$")
_ESCAPED = re.compile(r"([*|_\\])")


def setup(app: Any) -> dict[str, bool]:
    app.connect("autodoc-process-docstring", _process)
    return {"parallel_read_safe": True}


def _process(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = list(restructured(lines))


def restructured(lines: list[str]) -> Iterator[str]:
    """reStructuredText of a docstring's lines."""
    for paragraph in _paragraphs(lines):
        entries = _entries(paragraph)
        if entries:
            for names, text in entries:
                yield f":{_plain(names)}: {_plain(text)}"
        elif paragraph[0].startswith((" ", "\t")):
            yield "::"
            yield ""
            yield from (f"    {line}" for line in paragraph)
        else:
            yield from (_plain(line.strip()) for line in paragraph)
        yield ""


def _paragraphs(lines: list[str]) -> Iterator[list[str]]:
    """Lines between empty ones; a table of names is a paragraph of its own."""
    paragraph: list[str] = []
    table = False
    for line in [*lines, ""]:
        entry = not line.startswith(" ") and bool(_ENTRY.match(line))
        goes_on = entry or (table and line.startswith("    "))
        if paragraph and (not line.strip() or goes_on != table):
            yield paragraph
            paragraph = []
        if line.strip():
            paragraph.append(line)
        table = goes_on


def _entries(paragraph: list[str]) -> list[tuple[str, str]]:
    """Names and what they are, with lines that go on joined; none where it is no table."""
    if paragraph[0].startswith(" ") or not _ENTRY.match(paragraph[0]):
        return []
    found: list[tuple[str, str]] = []
    for line in paragraph:
        match = None if line.startswith(" ") else _ENTRY.match(line)
        if match:
            found.append((match["names"], match["text"]))
        elif found:
            found[-1] = found[-1][0], f"{found[-1][1]} {line.strip()}"
    return found


def _plain(text: str) -> str:
    """Text as it stands: only `code` has a meaning."""
    pieces = re.split(r"(`[^`]+`)", text)
    return "".join(
        f"``{piece[1:-1]}``" if piece.startswith("`") and len(piece) > 2 else _ESCAPED.sub(r"\\\1", piece)
        for piece in pieces
    )
