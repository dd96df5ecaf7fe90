"""What one page looks at; the URL holds it, so that a reload or a link shows the same."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal
from urllib.parse import urlencode

Place = Literal["data", "model", "where", "why", "next"]
PLACES: tuple[Place, ...] = ("data", "model", "where", "why", "next")


@dataclass(frozen=True)
class View:
    """place; log: its name; coordinate: of the equation; span: of time [s], None for all.

    band      of frequencies [Hz], None for all
    version   number of the model's version; None: whichever is in use
    """

    place: Place = "data"
    log: str = ""
    coordinate: str = ""
    span: tuple[float, float] | None = None
    band: tuple[float, float] | None = None
    version: int | None = None

    def at(self, **changes: Any) -> "View":
        """The same with something else."""
        return replace(self, **changes)

    @property
    def query(self) -> str:
        """As the part of a URL behind the question mark."""
        words = {"place": self.place, "log": self.log, "coordinate": self.coordinate}
        if self.span is not None:
            words["from"], words["to"] = (f"{t:.6g}" for t in self.span)
        if self.band is not None:
            words["low"], words["high"] = (f"{f:.6g}" for f in self.band)
        if self.version is not None:
            words["version"] = str(self.version)
        return urlencode({key: value for key, value in words.items() if value})


def view_of(query: Mapping[str, str]) -> View:
    """What a URL asks for; what makes no sense in it is left out."""
    place: Place = next((p for p in PLACES if p == query.get("place")), "data")  # pyright: ignore[reportAssignmentType]
    span, band = _pair(query, "from", "to"), _pair(query, "low", "high")
    if band is not None and not 0 <= band[0] < band[1]:
        band = None
    number = query.get("version", "")
    version = int(number) if number.isascii() and number.isdigit() and len(number) < 5 else None
    return View(place, query.get("log", ""), query.get("coordinate", ""), span, band, version)


def _pair(query: Mapping[str, str], first: str, second: str) -> tuple[float, float] | None:
    try:
        return float(query[first]), float(query[second])
    except (KeyError, ValueError):
        return None
