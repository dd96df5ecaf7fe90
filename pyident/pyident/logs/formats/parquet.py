"""Parquet files, and the data sets of LeRobot, whose names and rate stand in meta/info.json."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from pyident.logs.formats.joint_rows import by_joint
from pyident.logs.formats.recording import Recording
from pyident.logs.log import LogError

_TEXTS = (pa.types.is_string, pa.types.is_large_string, pa.types.is_dictionary)
_INFO = Path("meta/info.json")


def read_parquet(path: Path, episode: int | None = None) -> Recording:
    """Every numeric column; lists in cells under the names of meta/info.json, else as `name[1]` ...

    path      a file, or the folder of a LeRobot data set
    episode   of a data set; the first one of the file where none is given
    Raises LogError.
    """
    root = _root(path)
    info = _info(root) if root else {}
    file = _episode_file(path, episode or 0) if path.is_dir() else path
    columns: dict[str, np.ndarray] = {}
    texts: dict[str, pd.Series] = {}
    with pq.ParquetFile(file) as content:
        rows = _rows(content, file, episode) if root else None
        for name in content.schema_arrow.names:  # one at a time: a log may nearly fill the memory
            column = content.read([name])[name]
            column = column if rows is None else column.filter(rows)
            named = _names(info.get("features", {}).get(name, {}).get("names"))
            columns |= _columns(name, column, named)
            if not info and any(of(column.type) for of in _TEXTS):
                texts[name] = pd.Series(column.to_pandas())
    if not columns:
        raise LogError(f"{file} holds no column of numbers")
    if not info and (split := by_joint(columns, texts, str(path))) is not None:
        return split
    if "timestamp" not in columns and "fps" in info:
        length = len(next(iter(columns.values())))
        columns["timestamp"] = np.arange(length) / float(info["fps"])
    units = {"timestamp": "s"} if info else {}
    return Recording(columns, units)


def _rows(content: pq.ParquetFile, file: Path, episode: int | None) -> pa.ChunkedArray | None:
    """Which rows belong to an episode; None where they all do."""
    if "episode_index" not in content.schema_arrow.names:
        return None
    numbers = content.read(["episode_index"])["episode_index"]
    rows = pc.equal(numbers, numbers[0].as_py() if episode is None else episode)  # pyright: ignore
    if not pc.any(rows).as_py():  # pyright: ignore
        raise LogError(f"{file} holds no episode {episode}")
    return rows


def is_data_set(path: Path) -> bool:
    """Whether a folder holds a LeRobot data set."""
    return (path / _INFO).is_file()


def _root(path: Path) -> Path | None:
    places = [path, *path.resolve().parents][:5]
    return next((place for place in places if is_data_set(place)), None)


def _info(root: Path) -> dict[str, Any]:
    try:
        info = json.loads((root / _INFO).read_text(encoding="utf-8"))
    except (ValueError, OSError, RecursionError) as error:
        raise LogError(f"{root / _INFO} cannot be read ({str(error).splitlines()[0]})") from None
    features = info.get("features", {}) if isinstance(info, dict) else None
    if not isinstance(features, dict) or not all(isinstance(feature, dict) for feature in features.values()):
        raise LogError(f"{root / _INFO} must be a table with a table `features`, as LeRobot writes it")
    return info


def _episode_file(folder: Path, episode: int) -> Path:
    files = sorted((folder / "data").rglob("*.parquet"))
    if not files:
        raise LogError(f"{folder} has no data/*.parquet; give the folder of a LeRobot data set")
    own = [file for file in files if file.stem.endswith(f"{episode:06d}") and "episode" in file.stem]
    for file in own or files:
        if own or "episode_index" not in pq.read_schema(file).names:
            return file
        numbers = pq.read_table(file, columns=["episode_index"])["episode_index"]
        if pc.any(pc.equal(numbers, episode)).as_py():  # pyright: ignore
            return file
    raise LogError(f"{folder} holds no episode {episode}")


def _names(given: Any) -> list[str] | None:
    """LeRobot writes a list, or a dictionary with one."""
    if isinstance(given, dict):
        lists = [value for value in given.values() if isinstance(value, list)]
        given = lists[0] if len(lists) == 1 else None
    return [str(name) for name in given] if isinstance(given, list) else None


def _columns(name: str, column: pa.ChunkedArray, named: list[str] | None) -> dict[str, np.ndarray]:
    kind = column.type
    if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) or pa.types.is_large_list(kind):
        rows = column.to_pylist()
        if not rows or rows[0] is None or len({len(row) for row in rows}) != 1:
            return {}
        values = np.array(rows, dtype=object)
        if values.ndim != 2 or not isinstance(values[0, 0], int | float):
            return {}
        here = named if named and len(named) == values.shape[1] else None
        ends = [f".{n}" for n in here] if here else [f"[{i + 1}]" for i in range(values.shape[1])]
        if values.shape[1] == 1 and not here:
            ends = [""]
        return {name + end: x.astype(float) for end, x in zip(ends, values.T, strict=True)}
    if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind):
        return {name: column.to_pandas().to_numpy(float)}
    if pa.types.is_timestamp(kind):
        stamps = column.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy()
        return {name: 1e-9 * (stamps - stamps[0])}
    return {}
