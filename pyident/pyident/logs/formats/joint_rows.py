"""Tables with a row per joint, in turn: a column says whose row it is; each joint gets columns of its own."""

import re
from collections.abc import Mapping

import numpy as np
import pandas as pd

from pyident.logs.formats.interleaved import TIME
from pyident.logs.formats.recording import Recording
from pyident.logs.log import LogError

_JOINT = "(joint|axis|achse|gelenk|motor|servo|actuator|antrieb)"
_WORDS = re.compile(_JOINT, re.IGNORECASE)  # in the name of a column of words
_NUMBERS = re.compile(  # the name of a column of numbers
    rf"(?:.*[^a-z])?(?:{_JOINT}|can|node|device)s?[ _.-]?(?:id|no|nr|num|number|index|idx)?", re.IGNORECASE
)
_MOST = 64  # joints
_LEAST = 4  # rows of each
_LOOK = 1000  # rows, which hold all joints
_IN_TURN = 0.5  # of the rows, at least, that are of another joint than the row before
_ROUNDS = 0.9  # of the rows, at least, that are of the same joint as the one a round before
_TOGETHER = 0.4  # of the rows, at least, that have the stamp of the row before


def by_joint(
    columns: Mapping[str, np.ndarray], texts: Mapping[str, pd.Series], source: str
) -> Recording | None:
    """Columns (M,) as `JOINT.name`, with clocks where joints have their own; None where no rows alternate.

    columns, texts   the columns (N,) of numbers and of words
    What is the same for all joints keeps its name. Raises LogError where nothing says which rows belong
    together.
    """
    clock = next((name for name in columns if TIME.search(name)), None)
    key, labels = _joints_of(columns, texts, clock)
    if labels is None:
        return None
    rows = {str(joint): np.flatnonzero(labels == joint) for joint in dict.fromkeys(labels)}
    least = min(map(len, rows.values()))
    if max(map(len, rows.values())) <= least + 1:  # the last round may be cut off
        cut = {joint: own[:least] for joint, own in rows.items()}
        rows = cut if clock is None or _alike(columns[clock], cut) else rows
    elif clock is None:
        raise LogError(
            f"{source}: the rows of {len(rows)} joints alternate, as column {key} tells, but not evenly, and "
            "no column of time says which belong together; write one row per sample, in pandas with "
            f'frame.pivot(index="time", columns="{key}")'
        )
    split, clocks = _split({name: x for name, x in columns.items() if name != key}, rows, clock)
    note = (
        f"the rows of {len(rows)} joints alternate, as {key} tells: each joint has columns of its own here "
        f"({', '.join(name for name in split if name.startswith(f'{labels[0]}.'))} ...)"
    )
    return Recording(split, {}, clocks, True, (note,), tuple(name for name in texts if name != key))


def _joints_of(
    columns: Mapping[str, np.ndarray], texts: Mapping[str, pd.Series], clock: str | None
) -> tuple[str, np.ndarray | None]:
    """The column that tells the joint of each row, and the joints (N,) that it tells; None: there is none."""
    steps = np.diff(columns[clock]) if clock is not None else np.empty(0)
    together = bool(np.sum(steps == 0) > _TOGETHER * len(steps))
    for name in (*texts, *columns):
        labels = _labels(name, columns, texts)
        if labels is None:
            continue
        joints, codes, counts = np.unique(labels, return_inverse=True, return_counts=True)
        n = len(joints)
        if not 2 <= n <= _MOST or counts.min() < _LEAST or np.mean(np.diff(codes) != 0) <= _IN_TURN:
            continue
        rounds = bool(np.mean(codes[n:] == codes[:-n]) > _ROUNDS)
        named = name in columns or _WORDS.search(name) is not None
        if (rounds or together) if named else (rounds and together):
            return name, labels
    return "", None


def _labels(
    name: str, columns: Mapping[str, np.ndarray], texts: Mapping[str, pd.Series]
) -> np.ndarray | None:
    """What a column calls the joint of each row (N,), `shoulder` or `joint2`; None where it names none."""
    first = pd.Series(texts[name] if name in texts else columns[name]).iloc[:_LOOK]
    if not 2 <= first.nunique() <= _MOST:
        return None
    if name in texts:
        return texts[name].astype(str).str.strip().to_numpy(str)
    said, x = _NUMBERS.fullmatch(name), columns[name]
    if said is None or not np.isfinite(x).all() or (x != np.round(x)).any():
        return None
    return np.array([f"{(said[1] or 'joint').lower()}{int(number)}" for number in x])


def _split(
    columns: Mapping[str, np.ndarray], rows: Mapping[str, np.ndarray], clock: str | None
) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Columns (M,) by joint, and column -> its clock; rows: joint -> its rows (M,) of the table.

    The joint with the most rows keeps the clock's own name.
    """
    shared = [name for name, x in columns.items() if _alike(x, rows)]
    first = max(rows, key=lambda joint: len(rows[joint]))
    out = {name: columns[name][rows[first]] for name in columns if name in (*shared, clock)}
    clocks: dict[str, str] = {}
    for joint, own in rows.items():
        names = [name for name in columns if name not in (*shared, clock)]
        if clock is not None and clock not in shared and joint != first:
            out[f"{clock} of {joint}"] = columns[clock][own]
            clocks |= {f"{joint}.{name}": f"{clock} of {joint}" for name in names}
        out |= {f"{joint}.{name}": columns[name][own] for name in names}
    return out, clocks


def _alike(x: np.ndarray, rows: Mapping[str, np.ndarray]) -> bool:
    """Whether a column (N,) is the same in the rows of every joint."""
    first, *others = (x[own] for own in rows.values())
    return all(np.array_equal(first, other, equal_nan=True) for other in others)
