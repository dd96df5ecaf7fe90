"""Time series of a robot, simulated or measured: read, checked, written.

Columns: `time` [s]; per joint k from 1 `joint{k}.e`, `joint{k}.eps[1..3]`, `joint{k}.tau`, optionally
`joint{k}.r`, `joint{k}.tau_ff`; optionally `tip.x`, `tip.y`, `tip.z`. SI units throughout.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
import pandas as pd
from scipy.io import loadmat, savemat

from flexmodels.atomic import replacing
from flexmodels.robot import Robot
from flexmodels.settings.processing import Column
from pyident.logs.gaps import WIDEST_GAP, in_short_gaps

_JITTER = 0.01  # of one period: what still counts as uniform


class LogError(ValueError):
    """A log that cannot be used; the message says what, where and how to mend it."""


class Sampled(Protocol):
    """What every log says of itself: columns, period [s], when it began [s], length, what was done to it."""

    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def period(self) -> float: ...
    @property
    def began(self) -> float: ...
    @property
    def source(self) -> str: ...
    @property
    def notes(self) -> tuple[str, ...]: ...
    def __len__(self) -> int: ...


@dataclass(frozen=True)
class Log:
    """Uniformly sampled signals; checked when it is made, which raises LogError.

    frame   column `time` [s] and one column per signal (SI units), a row per sample
    source  what messages call it
    notes   what was done to it, a sentence each
    up_to_constant   torques that are known but for a constant of this log, which no equation may read
    after   time [s] that its recording had run before its first row
    by_servo         whether its torques are what servos make of commands and positions
    """

    frame: pd.DataFrame
    source: str = "the log"
    notes: tuple[str, ...] = ()
    up_to_constant: tuple[str, ...] = ()
    after: float = 0.0
    by_servo: bool = False

    def __post_init__(self) -> None:
        check(self.frame, self.source)

    @classmethod
    def from_frame(cls, frame: pd.DataFrame, source: str = "the data frame") -> "Log":
        """The same, its rows counted anew from 0. Raises LogError."""
        return cls(frame.reset_index(drop=True), source)

    @property
    def names(self) -> tuple[str, ...]:
        """Its columns, `time` among them."""
        return tuple(self.frame)

    @property
    def period(self) -> float:
        """Sample time [s]."""
        time = self.frame["time"].to_numpy()
        return float((time[-1] - time[0]) / (len(time) - 1))

    @property
    def began(self) -> float:
        """Time at which its recording began [s]: a controller's clock may run since it was switched on."""
        return float(self.frame["time"].iloc[0]) - self.after

    def __repr__(self) -> str:
        return (
            f"<Log {self.source}: {len(self)} samples at {1 / self.period:.4g} Hz, {len(self.names)} columns>"
        )

    def __len__(self) -> int:
        return len(self.frame)

    def signals(self, names: list[str] | tuple[str, ...]) -> np.ndarray:
        """The named columns as (N, len(names))."""
        return self.frame[list(names)].to_numpy(dtype=float, copy=True)

    def noisier(self, noise: Mapping[str, float], rng: np.random.Generator) -> "Log":
        """With white noise in its sensors: column -> standard deviation."""
        added = {name: self.frame[name] + s * rng.standard_normal(len(self)) for name, s in noise.items()}
        return replace(self, frame=self.frame.assign(**added))


def no_log(path: Path) -> str:
    """That a file is missing, and what a NAME=VALUE among the logs was meant as."""
    if "=" in path.name:
        return f"there is no log {path}; if it is a value, give an option for each: --set A=1 --set B=2"
    return f"there is no log {path}; check the path"


def read_log(path: str | Path, columns: Mapping[str, Column] | None = None) -> Log:
    """Read CSV, Parquet or MAT by its ending; `columns` maps foreign names and units. Raises LogError."""
    path = Path(path)
    if not path.is_file():
        raise LogError(no_log(path))
    readers = {".csv": _read_csv, ".parquet": pd.read_parquet, ".mat": _read_mat}
    if path.suffix not in readers:
        raise LogError(
            f"{path}: a log must end in .csv, .parquet or .mat; pyident log import makes one of other files"
        )
    with reading(path):
        frame = renamed(readers[path.suffix](path), columns or {}, str(path))
    return Log.from_frame(frame, str(path))


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """What goes wrong in other people's readers becomes a LogError."""
    try:
        yield
    except LogError:
        raise
    except Exception as error:
        raise LogError(f"{path} cannot be read as {path.suffix[1:]} ({str(error).splitlines()[0]})") from None


def write_log(log: Log, path: str | Path) -> None:
    """Write a log as CSV, Parquet or MAT by the ending of `path`. Raises LogError."""
    path = Path(path)
    if path.suffix not in (".csv", ".parquet", ".mat"):
        raise LogError(f"{path}: a log must end in .csv, .parquet or .mat")
    with replacing(path) as file:
        if path.suffix == ".csv":
            log.frame.to_csv(file, index=False)
        elif path.suffix == ".parquet":
            log.frame.to_parquet(file, index=False)
        else:
            names = {f"c{i}": log.frame[name].to_numpy() for i, name in enumerate(log.frame)}
            savemat(file, names | {"columns": np.array(list(log.frame), dtype=object)})


def require(log: Sampled, robot: Robot, samples: int) -> None:
    """Check that the log has what identifying this robot needs. Raises LogError."""
    needed = [*robot.coordinates, *robot.torques]
    missing = [name for name in needed if name not in log.names]
    if missing:
        raise LogError(
            f"{log.source}: column {missing[0]} is missing, which robot {robot.name} needs; "
            f"add it, or map it under [columns] in the robot file"
        )
    if len(log) < samples:
        raise LogError(
            f"{log.source}: {len(log)} samples are too few; robot {robot.name} needs {samples} or more"
        )


def _read_csv(path: Path) -> pd.DataFrame:
    require_names_once(path)
    return pd.read_csv(path)


def require_names_once(path: Path) -> None:
    """Raises LogError for a CSV in which a name comes twice: pandas calls the second column NAME.1."""
    names = pd.read_csv(path, header=None, nrows=1, dtype=str).iloc[0]
    twice = names[names.duplicated()]
    if len(twice):
        raise LogError(f"{path}: column {twice.iloc[0]} is there twice; remove one of them or rename it")


def _read_mat(path: Path) -> pd.DataFrame:
    """Vectors of a MAT file (version 7 or older) as columns; those of the longest length count."""
    content = {k: v for k, v in loadmat(path, squeeze_me=True).items() if not k.startswith("__")}
    if "columns" in content:
        return pd.DataFrame(
            {str(name): content[f"c{i}"] for i, name in enumerate(np.atleast_1d(content["columns"]))}
        )
    vectors = {
        k: v
        for k, v in content.items()
        if isinstance(v, np.ndarray) and v.ndim == 1 and v.dtype.kind in "fiu"
    }
    if not vectors:
        raise LogError(f"{path} holds no numeric vectors")
    length = max(len(v) for v in vectors.values())
    return pd.DataFrame({k: v for k, v in vectors.items() if len(v) == length})


def renamed(frame: pd.DataFrame, columns: Mapping[str, Column], source: str) -> pd.DataFrame:
    """Columns under the contract's names; a file that has them already is taken as it is. Raises LogError."""
    out = {}
    for signal, column in columns.items():
        if column.source in frame:
            out[signal] = frame[column.source] * column.gain if column.gain != 1 else frame[column.source]
        elif signal not in frame:
            raise LogError(
                f"{source}: column {column.source} is missing, from which {signal} is read; add it"
            )
    kept = {name: frame[name] for name in frame if name not in out}
    return pd.DataFrame(out | kept)


def check(frame: pd.DataFrame, source: str) -> None:
    """Raises LogError unless the frame is a uniformly sampled log of finite numbers."""
    check_columns(frame, source)
    if len(frame) < 2:
        raise LogError(f"{source}: {len(frame)} samples are too few")
    time = frame["time"].to_numpy(dtype=float)
    check_steps(time, median_step(time), source)


def check_columns(frame: pd.DataFrame, source: str, first: int = 0) -> None:
    """Time is there and everything is a finite number; `first` rows came before. Raises LogError."""
    if "time" not in frame:
        raise LogError(
            f"{source}: column time is missing; add it in seconds, or map columns of other names: "
            "`pyident log inspect` writes a mapping, --mapping takes it"
        )
    for name in frame:
        if not pd.api.types.is_numeric_dtype(frame[name]):
            raise LogError(f"{source}: {_no_number(pd.Series(frame[name]), first)}")
        values = frame[name].to_numpy(dtype=float)
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            time = frame["time"].to_numpy(dtype=float)
            when = "" if name == "time" else f" (time {time[bad[0]]:.6g} s)"
            short = name != "time" and in_short_gaps(time, values)[bad].all()
            cure = "let `pyident log import` fill it" if short else "fill the gap"
            raise LogError(
                f"{source}: column {name} is not finite in {len(bad)} rows, first in row "
                f"{first + bad[0] + 1}{when}; cut the log there or {cure}"
            )


def _no_number(column: pd.Series, first: int) -> str:
    """Where a column holds a text, and which; `first` rows came before."""
    if not len(column):
        return "there are names of columns, and no rows below them"
    numbers, told = np.asarray(pd.to_numeric(column, errors="coerce"), float), np.asarray(column.notna())
    bad = np.flatnonzero(np.isnan(numbers) & told)
    if len(bad) == told.sum():
        return f"column {column.name} holds nothing that is a number; remove it"
    text = str(column.iloc[bad[0]])[:40]
    return (
        f"column {column.name} holds {text!r} in row {first + bad[0] + 1}, which is no number"
        f"{f', and {len(bad) - 1} more' if len(bad) > 1 else ''}; remove such rows, or the column"
    )


def median_step(time: np.ndarray) -> float:
    """[s] between the samples of a time column (N,)."""
    return float(np.median(np.diff(time)))


def check_steps(time: np.ndarray, period: float, source: str, first: int = 0) -> None:
    """Time (N,) [s] goes on in steps of one period; `first` rows came before. Raises LogError."""
    uneven = np.flatnonzero(np.abs(np.diff(time) - period) > _JITTER * abs(period))
    if period <= 0:
        how = "stands still" if period == 0 else "runs backwards"
        raise LogError(
            f"{source}: time {how} through most of the rows; is it the column of the time, in order?"
        )
    if len(uneven):
        i = int(uneven[0]) if len(uneven) else 0
        steps = np.diff(time)
        short = steps.max() <= WIDEST_GAP * period and steps.min() > 0
        raise LogError(
            f"{source}: time goes from {time[i]:.13g} s to {time[i + 1]:.13g} s at row {first + i + 2} where "
            f"the period is {period:.6g} s; cut the log there"
            f"{', or let `pyident log import` resample it' if short else ''}"
        )
