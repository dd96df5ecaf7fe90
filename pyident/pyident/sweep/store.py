"""Rows of a study on disk: each batch in a file of its own as soon as it is there, one table at the end."""

import json
import shutil
from pathlib import Path

import pandas as pd

from flexmodels.atomic import replacing


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
        self._parts.mkdir(parents=True, exist_ok=True)
        note = self._folder / "study.json"
        if not note.exists():
            with replacing(note) as file:
                file.write_text(json.dumps({"fingerprint": fingerprint}) + "\n", encoding="utf-8")
        elif json.loads(note.read_text(encoding="utf-8")).get("fingerprint") != fingerprint:
            raise StudyError(
                f"{self._folder} holds another study (other parameters, model, experiment or metrics); "
                "name another folder or remove this one"
            )

    @property
    def results(self) -> Path:
        return self._folder / "results.parquet"

    def rows(self) -> pd.DataFrame:
        """What is finished, sorted by `run`, each run once."""
        files = [self.results] if self.results.exists() else sorted(self._parts.glob("[0-9]*.parquet"))
        if not files:
            return pd.DataFrame({"run": pd.Series(dtype=int)})
        frame = pd.concat([pd.read_parquet(file) for file in files], ignore_index=True)
        return frame.drop_duplicates("run").sort_values("run", ignore_index=True)

    def add(self, rows: pd.DataFrame) -> None:
        """Keep a batch; its first run names the file."""
        with replacing(self._parts / f"{rows['run'].iloc[0]:08d}.parquet") as file:
            rows.to_parquet(file, index=False)

    def finish(self, design: pd.DataFrame) -> pd.DataFrame:
        """Write and return the table: parameters beside results, index `run`."""
        if not self.results.exists():
            rows = self.rows()
            table = pd.concat([design.loc[rows["run"]].reset_index(drop=True), rows], axis=1)
            with replacing(self.results) as file:
                table.to_parquet(file, index=False)
        shutil.rmtree(self._parts, ignore_errors=True)
        return pd.read_parquet(self.results).set_index("run")
