"""JSON: an object per row (a line each, or a list of them), or an object of lists."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pyident.logs.formats.cells import numbers_of
from pyident.logs.formats.recording import Recording
from pyident.logs.formats.table import recording_of
from pyident.logs.log import LogError


def read_json(path: Path) -> Recording:
    """Every number by its path (`state.q[2]`); messages of joints as `JOINT.position`. Raises LogError."""
    found, notes = _rows(path)
    rows = [row for row in found if isinstance(row, dict)]
    if not rows:
        raise LogError(f"{path} holds no rows: neither an object per line, nor a list of objects, nor lists")
    frame = pd.DataFrame([dict(_numbers_and_words(row, "")) for row in rows])
    columns: dict[str, np.ndarray] = {}
    texts: dict[str, pd.Series] = {}
    for name in frame:
        column = pd.Series(frame[name])
        found = numbers_of(str(name), column, [], ".")
        columns |= found
        if not found:
            words = set(column.dropna())
            texts[str(name)] = column.fillna(words.pop()) if len(words) == 1 else column
    return recording_of(columns, texts, str(path), notes=notes)


def _rows(path: Path) -> tuple[list[Any], list[str]]:
    """What a file holds, a row each, and a note on a last line that is incomplete."""
    text = path.read_text("utf-8-sig")
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        if error.lineno == 1 and "\n" not in text.strip():
            raise
        return _lines(text.splitlines())
    if isinstance(content, Mapping):
        content = _longest(content)
    return content, []


def _lines(lines: list[str]) -> tuple[list[Any], list[str]]:
    lines = [line for line in lines if line.strip()]
    rows = []
    for i, line in enumerate(lines):
        try:
            rows.append(json.loads(line))
        except json.JSONDecodeError:
            if i < len(lines) - 1 or not rows:
                raise
            return rows, ["the last line, which is incomplete, left out"]
    return rows, []


def _longest(content: Mapping[str, Any]) -> list[Any]:
    """The rows of an object: its longest list of objects, or its lists side by side, or itself."""
    lists = {name: x for name, x in _lists(content, "") if x}
    objects = [x for x in lists.values() if isinstance(x[0], dict)]
    if objects:
        return max(objects, key=len)
    if not lists:
        return [content]
    longest = max(map(len, lists.values()))
    whole = {name: x for name, x in lists.items() if len(x) == longest}
    return [dict(zip(whole, row, strict=True)) for row in zip(*whole.values(), strict=True)]


def _lists(value: Any, name: str) -> Iterator[tuple[str, list[Any]]]:
    if isinstance(value, list):
        yield name, value
    elif isinstance(value, Mapping):
        for part, inside in value.items():
            yield from _lists(inside, f"{name}.{part}" if name else str(part))


def _numbers_and_words(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    """What stands at the ends of an object, by its path; places in a list count from 1."""
    if isinstance(value, Mapping):
        for part, inside in value.items():
            yield from _numbers_and_words(inside, f"{name}.{part}" if name else str(part))
    elif isinstance(value, list):
        for i, inside in enumerate(value, 1):
            yield from _numbers_and_words(inside, f"{name}[{i}]")
    else:
        yield name, value
