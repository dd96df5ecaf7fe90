"""Rows of a study on disk: each batch in a file of its own as soon as it is there, one table at the end."""

import json
import os
import shutil
from pathlib import Path
from weakref import finalize

import numpy as np
import pandas as pd

from flexmodels.atomic import replacing

if os.name == "posix":
    import fcntl


class StudyError(ValueError):
    """A study that cannot be run; the message says what is wrong, and where."""


class ResultsStore:
    """The finished rows of one study in `folder`.

    study.json        fingerprint: what the study is (rows of another one are not taken for its own)
    parts/*.parquet   finished batches, gone when all is done
    results.parquet   every row, written when all is done
    A row has the column `run`, its position in the design, and any others.
    Raises StudyError when the folder holds another study.
    """

    def __init__(self, folder: str | Path, fingerprint: str):
        self._folder = Path(folder)
        self._parts = self._folder / "parts"
        note = self._folder / "study.json"
        if not note.exists():
            self._require_free()
        self._parts.mkdir(parents=True, exist_ok=True)
        self._release = finalize(self, os.close, _locked(self._folder)) if os.name == "posix" else None
        if not note.exists():
            with replacing(note) as file:
                file.write_text(json.dumps({"fingerprint": fingerprint}) + "\n", encoding="utf-8")
        elif _fingerprint(note) != fingerprint:
            raise StudyError(
                f"{self._folder} holds another study (other parameters, model, experiment or metrics); "
                "name another folder or remove this one"
            )

    def close(self) -> None:
        """Let others write into the folder."""
        if self._release is not None:
            self._release()

    @property
    def results(self) -> Path:
        return self._folder / "results.parquet"

    def rows(self) -> pd.DataFrame:
        """What is finished, sorted by `run`, each run once."""
        files = [*([self.results] if self.results.exists() else []), *self._batches()]
        if not files:
            return pd.DataFrame({"run": pd.Series(dtype=int)})
        frame = pd.concat([_read(file) for file in files], ignore_index=True)
        return frame.drop_duplicates("run").sort_values("run", ignore_index=True)

    def add(self, rows: pd.DataFrame) -> None:
        """Keep a batch; its first run names the file."""
        with replacing(self._parts / f"{rows['run'].iloc[0]:08d}.parquet") as file:
            rows.to_parquet(file, index=False)

    def finish(self, design: pd.DataFrame) -> pd.DataFrame:
        """Write and return the table: parameters beside results, index `run`. Raises StudyError."""
        if not self.results.exists() or self._batches():
            rows = self.rows()
            rows = rows.drop(columns=[name for name in design if name in rows])
            if not np.isin(rows["run"].to_numpy(), design.index.to_numpy()).all():
                raise StudyError(f"{self._folder} holds runs of another design; name another folder")
            table = pd.concat([design.loc[rows["run"]].reset_index(drop=True), rows], axis=1)
            with replacing(self.results) as file:
                table.to_parquet(file, index=False)
        shutil.rmtree(self._parts, ignore_errors=True)
        return _read(self.results).set_index("run")

    def _batches(self) -> list[Path]:
        return sorted(self._parts.glob("[0-9]*.parquet"))

    def _require_free(self) -> None:
        """What lies under our names but is no study of ours is not to be replaced."""
        for path in (self.results, self._parts):
            if path.exists():
                raise StudyError(f"{path} exists, but there is no study.json beside it; name another folder")


def _locked(folder: Path) -> int:
    """A descriptor of the folder; the lock holds until it is closed, at the latest by the process's end."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        raise StudyError(f"another sweep is at work in {folder}; wait for it, or name another one") from None
    return descriptor


def _fingerprint(note: Path) -> str:
    try:
        content = json.loads(note.read_text(encoding="utf-8"))
        return str(content["fingerprint"])
    except (ValueError, RecursionError, TypeError, KeyError):
        raise StudyError(f"{note} is damaged; remove the folder {note.parent}, or name another one") from None


def _read(file: Path) -> pd.DataFrame:
    try:
        frame = pd.read_parquet(file)
        kinds = {str(name): np.asarray(frame[name]).dtype.kind for name in frame if name != "failure"}
        whole = kinds["run"] in "iu" and set(kinds.values()) <= set("fiub")
        whole = whole and bool(np.all(np.asarray(frame["run"]) >= 0))
    except OSError:
        raise
    except Exception:
        whole, frame = False, pd.DataFrame()
    if not whole:
        raise StudyError(f"{file} is damaged; remove it, and the same call computes its runs again")
    return frame
