"""Long logs stay on disk: checked once, then read block by block as often as they are needed."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from flexmodels.settings.processing import Column
from pyident.logs.log import (
    Log,
    LogError,
    check_columns,
    check_steps,
    median_step,
    read_log,
    reading,
    renamed,
    require_names_once,
)

LARGE = 16_000_000  # bytes of numbers (Parquet) or text (CSV) from which a log stays on disk
ROWS = 8_192  # of a block
_BUFFER = 1 << 16  # bytes of a column that are read at a time


@dataclass(frozen=True)
class Window:
    """Neighbouring samples of a log: its own rows and, as far as the log reaches, a margin on either side.

    values  (rows, signals);  first: the log's number of row 0;  own: the rows that no other window owns
    """

    values: np.ndarray
    first: int
    own: slice


@dataclass(frozen=True)
class LogFile:
    """A uniformly sampled log in a CSV or Parquet file. period: sample time, began: of its first [s]."""

    path: Path
    columns: Mapping[str, Column] = field(repr=False)
    names: tuple[str, ...]
    length: int
    period: float
    began: float
    notes: tuple[str, ...] = ()

    @property
    def source(self) -> str:
        return str(self.path)

    def __len__(self) -> int:
        return self.length

    def windows(self, names: list[str], own: int, margin: int) -> Iterator[Window]:
        """The named signals in windows of `own` rows between margins; each row is read once."""
        held, first, at = np.empty((0, len(names))), 0, 0
        for frame in _frames(self.path, self.columns, names):
            held = np.concatenate([held, frame[names].to_numpy(dtype=float)])
            read = first + len(held)
            while at < self.length and read >= min(at + own + margin, self.length):
                stop = min(at + own, self.length)
                yield Window(held[: stop + margin - first], first, slice(at - first, stop - first))
                at = stop
                drop = max(at - margin - first, 0)
                held, first = held[drop:], first + drop


def open_log(path: str | Path, columns: Mapping[str, Column] | None = None) -> Log | LogFile:
    """A log for reading: in memory, or on disk when it is long. Raises LogError for what cannot be used."""
    path, columns = Path(path), columns or {}
    return log_file(path, columns) if _bytes(path) > LARGE else read_log(path, columns)


def log_file(path: str | Path, columns: Mapping[str, Column] | None = None) -> LogFile:
    """Go through a CSV or Parquet file once and check every row. Raises LogError."""
    path, columns = Path(path), columns or {}
    length, names, period, ends = 0, (), None, np.empty(0)
    if path.suffix == ".csv":
        with reading(path):
            require_names_once(path)
    for frame in _frames(path, columns):
        names = tuple(frame)
        check_columns(frame, str(path), length)
        time = frame["time"].to_numpy(dtype=float)
        period = median_step(time) if period is None and len(time) > 1 else period
        if period is not None:
            check_steps(np.append(ends[1:], time), period, str(path), max(length - 1, 0))
        length += len(time)
        ends = np.array([ends[0] if len(ends) else time[0], time[-1]])
    if length < 2:
        raise LogError(f"{path}: {length} samples are too few")
    begin, end = ends.tolist()
    return LogFile(path, columns, names, length, (end - begin) / (length - 1), begin)


def _frames(
    path: Path, columns: Mapping[str, Column], names: Sequence[str] | None = None
) -> Iterator[pd.DataFrame]:
    """The rows block by block, under the contract's names; only the named signals. Raises LogError."""
    if names is not None:
        columns = {name: columns[name] for name in names if name in columns}
    wanted = None if names is None else {*names, *(column.source for column in columns.values())}
    with reading(path):
        for frame in (_csv_frames if path.suffix == ".csv" else _parquet_frames)(path, wanted):
            yield renamed(frame, columns, str(path))


def _csv_frames(path: Path, wanted: set[str] | None) -> Iterator[pd.DataFrame]:
    usecols = None if wanted is None else lambda name: name in wanted
    with pd.read_csv(path, chunksize=ROWS, usecols=usecols) as chunks:
        yield from chunks


def _parquet_frames(path: Path, wanted: set[str] | None) -> Iterator[pd.DataFrame]:
    with pq.ParquetFile(path, buffer_size=_BUFFER, pre_buffer=False) as file:
        names = [name for name in file.schema_arrow.names if wanted is None or name in wanted]
        for batch in file.iter_batches(ROWS, columns=names, use_threads=False):
            yield batch.to_pandas(use_threads=False)


def _bytes(path: Path) -> int:
    if not path.is_file() or path.suffix not in (".csv", ".parquet"):
        return 0
    if path.suffix == ".csv":
        return path.stat().st_size
    with reading(path):
        found = pq.read_metadata(path)
        return 8 * found.num_rows * found.num_columns
