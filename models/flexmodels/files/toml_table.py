"""A TOML table that complains in one sentence."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmodels.robot import RobotError


class Table:
    """A TOML table that knows its place, so that every complaint names the key."""

    def __init__(self, data: Any, where: str):
        if not isinstance(data, Mapping):
            raise RobotError(f"{where} must be a table")
        self.data, self.where, self.read = data, where, set()

    def place(self, key: str) -> str:
        return f"{self.where}.{key}" if self.where else key

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def get(self, key: str, default: Any = None) -> Any:
        self.read.add(key)
        if key in self.data:
            return self.data[key]
        if default is None:
            raise RobotError(f"{self.place(key)} is missing")
        return default

    def number(
        self, key: str, default: float | None = None, lower: float = -np.inf, above: bool = False
    ) -> float:
        return number(self.get(key, default), self.place(key), lower, above)

    def vector(self, key: str, size: int, default: Any = None, lower: float = -np.inf) -> tuple[float, ...]:
        value = self.get(key, default)
        if not isinstance(value, list | tuple) or len(value) != size:
            raise RobotError(f"{self.place(key)} must be {size} numbers")
        return tuple(number(v, f"{self.place(key)}[{i + 1}]", lower) for i, v in enumerate(value))

    def whole(self, value: Any, key: str, lower: int, upper: int) -> int:
        """A value found at `key` as a whole number."""
        found = number(value, self.place(key))
        if found != int(found) or not lower <= found <= upper:
            raise RobotError(f"{self.place(key)} must be a whole number from {lower} to {upper}, not {value}")
        return int(found)

    def flag(self, key: str) -> bool:
        self.read.add(key)
        value = self.data.get(key, False)
        if not isinstance(value, bool):
            raise RobotError(f"{self.place(key)} must be true or false, not {value!r}")
        return value

    def table(self, key: str) -> "Table":
        return Table(self.get(key), self.place(key))

    def tables(self, key: str) -> list["Table"]:
        value = self.get(key)
        if not isinstance(value, list) or not value:
            raise RobotError(f"{self.place(key)} must be a list of tables ([[{key}]])")
        return [Table(v, f"{self.place(key)}[{i + 1}]") for i, v in enumerate(value)]

    def done(self) -> None:
        unknown = sorted(set(self.data) - self.read)
        if unknown:
            raise RobotError(f"{self.place(unknown[0])} is not a known key; remove or rename it")


def number(value: Any, place: str, lower: float = -np.inf, above: bool = False) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise RobotError(f"{place} must be a finite number, not {value!r}")
    if value < lower or (above and value <= lower):
        raise RobotError(f"{place} = {value} must be {'above' if above else 'at least'} {lower:g}")
    return float(value)
