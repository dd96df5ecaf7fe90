"""A self-contained HTML page of text, tables and figures, readable without a server."""

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, PackageLoader
from matplotlib.figure import Figure

from flexmodels.atomic import replacing


@dataclass(frozen=True)
class Picture:
    """A figure with the sentence that says what it shows."""

    figure: Figure
    caption: str


@dataclass(frozen=True)
class Section:
    """A heading, what it says, and what it shows."""

    title: str
    text: str = ""
    pictures: Sequence[Picture] = ()
    table: pd.DataFrame | None = None


def write_page(path: Path, title: str, summary: str, sections: Sequence[Section]) -> Path:
    """Write the page and return its path."""
    content: list[dict[str, Any]] = [
        {
            "title": s.title,
            "text": s.text,
            "table": s.table,
            "figures": [{"caption": p.caption, "data": _png(p.figure)} for p in s.pictures],
        }
        for s in sections
    ]
    environment = Environment(loader=PackageLoader("pyident", "report/templates"), autoescape=True)
    html = environment.get_template("page.html").render(title=title, summary=summary, sections=content)
    with replacing(path) as file:
        file.write_text(html, encoding="utf-8")
    return path


def _png(figure: Figure) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130)
    return base64.b64encode(buffer.getvalue()).decode()
