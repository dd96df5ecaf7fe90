"""A TOML table that complains in one sentence."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flexmodels.robot import RobotError

LARGEST_NUMBER = 1e30  # of any quantity in SI units: its square and its product with others stay finite
_LARGEST = 20_000_000  # bytes of a TOML file
_LONGEST = 1_000  # characters of a text
_DIGITS, _SHOWN = 40, 80  # of a whole number, of any value that a sentence shows


class Table:
    """A TOML table that knows its place, so that every complaint names the key."""

    def __init__(self, data: Any, where: str):
        if not isinstance(data, Mapping):
            raise RobotError(f"{where} must be a table")
        self.data, self.where, self.read = data, where, set()

    def place(self, key: str) -> str:
        """The key as a sentence names it."""
        return f"{self.where}.{key}" if self.where else key

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def get(self, key: str, default: Any = None) -> Any:
        """Any value. Raises RobotError where it is missing and there is no default."""
        self.read.add(key)
        if key in self.data:
            return self.data[key]
        if default is None:
            near = [other for other in self.data if str(other).lower() == key.lower()]
            beside = f"; {self.place(str(near[0]))} is there, and capitals matter" if near else ""
            raise RobotError(f"{self.place(key)} is missing{beside}")
        return default

    def text(self, key: str, default: str | None = None) -> str:
        """A line of text."""
        return line_of_text(self.get(key, default), self.place(key))

    def number(
        self, key: str, default: float | None = None, lower: float = -np.inf, above: bool = False
    ) -> float:
        """Finite, from `lower` on or above it. Raises RobotError."""
        return number(self.get(key, default), self.place(key), lower, above)

    def vector(self, key: str, size: int, default: Any = None) -> tuple[float, ...]:
        """So many numbers. Raises RobotError."""
        value = self.get(key, default)
        if not isinstance(value, list | tuple) or len(value) != size:
            raise RobotError(f"{self.place(key)} must be {size} numbers")
        return tuple(number(v, f"{self.place(key)}[{i + 1}]") for i, v in enumerate(value))

    def whole(self, value: Any, key: str, lower: int, upper: int) -> int:
        """A value found at `key` as a whole number. Raises RobotError."""
        found = number(value, self.place(key))
        if found != int(found) or not lower <= found <= upper:
            raise RobotError(
                f"{self.place(key)} must be a whole number from {lower} to {upper}, not {shortened(value)}"
            )
        return int(found)

    def flag(self, key: str) -> bool:
        """True or false, false where it is absent. Raises RobotError."""
        self.read.add(key)
        value = self.data.get(key, False)
        if not isinstance(value, bool):
            raise RobotError(f"{self.place(key)} must be true or false, not {shortened(value)}")
        return value

    def table(self, key: str) -> "Table":
        """A table in this one. Raises RobotError."""
        return Table(self.get(key), self.place(key))

    def tables(self, key: str) -> list["Table"]:
        """A list of tables, at least one. Raises RobotError."""
        value = self.get(key)
        if not isinstance(value, list) or not value:
            raise RobotError(f"{self.place(key)} must be a list of tables ([[{key}]])")
        return [Table(v, f"{self.place(key)}[{i + 1}]") for i, v in enumerate(value)]

    def done(self) -> None:
        """Raises RobotError where a key was never asked for."""
        unknown = sorted(set(self.data) - self.read)
        if unknown:
            raise RobotError(f"{self.place(unknown[0])[:_SHOWN]} is not a known key; remove or rename it")


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file. Raises RobotError."""
    try:
        if path.stat().st_size > _LARGEST:
            raise RobotError(f"{path}: more than {_LARGEST // 10**6} MB are too much for a TOML file")
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except RecursionError:
        raise RobotError(f"{path}: not a TOML file (its tables are nested too deeply)") from None
    except ValueError as error:  # of TOML, of UTF-8, and of whole numbers with thousands of digits
        raise RobotError(f"{path}: not a TOML file ({error})") from None


def line_of_text(value: Any, place: str) -> str:
    """Text that may stand in XML, on pages and in a terminal. Raises RobotError."""
    if not isinstance(value, str) or len(value) > _LONGEST or not value.isprintable():
        raise RobotError(f"{place} must be one line of printable text of at most {_LONGEST} characters")
    return value


def number(value: Any, place: str, lower: float = -np.inf, above: bool = False) -> float:
    """A finite number from `lower` on or above it. Raises RobotError."""
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value:
        raise RobotError(f"{place} must be a finite number, not {shortened(value)}")
    if abs(value) > LARGEST_NUMBER:
        raise RobotError(f"{place} must be a finite number up to {LARGEST_NUMBER:g}, not {shortened(value)}")
    if value < lower or (above and value <= lower):
        raise RobotError(f"{place} = {shortened(value)} must be {'above' if above else 'at least'} {lower:g}")
    return float(value)


def shortened(value: Any) -> str:
    """Any value as a sentence shows it."""
    if isinstance(value, int) and abs(value) >= 10**_DIGITS:
        return f"a whole number of more than {_DIGITS} digits"
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
