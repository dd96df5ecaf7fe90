"""What every outcome of a verb can do: tell itself in words, as a table, for machines, and in a notebook."""

import json
from abc import ABC, abstractmethod
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

    from pyident.verbs.text import Text


class Result(ABC):
    """The outcome of a verb: frozen; `notes` says what was done to the logs, a sentence each."""

    @abstractmethod
    def summary(self) -> "Text":
        """The outcome in words and tables, readable in a terminal."""

    @abstractmethod
    def to_frame(self) -> "pd.DataFrame":
        """The outcome as one table."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The outcome for machines, as the command's `--json` writes it."""

    @abstractmethod
    def headline(self) -> str:
        """The outcome in a line."""

    def to_json(self, path: str | Path | None = None) -> str:
        """`to_dict` as JSON; also written to `path` if one is given."""
        from flexmodels.atomic import replacing

        text = json.dumps(self.to_dict(), indent=2) + "\n"
        if path is not None:
            with replacing(path) as file:
                file.write_text(text, encoding="utf-8")
        return text

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.headline()}>"

    def _repr_html_(self) -> str:
        frame = self.to_frame()
        table = frame.to_html(float_format=lambda x: f"{x:.4g}") if len(frame) else ""
        return f"<p>{escape(self.headline())}</p>{table}"
