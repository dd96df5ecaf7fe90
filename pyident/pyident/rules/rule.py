"""A threshold with what it is of, why it has its value, and the data on which that was fixed."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any


class RulesError(ValueError):
    """Thresholds that contradict each other; the message names them and the cure."""


@dataclass(frozen=True)
class Line:
    """One threshold as it is listed."""

    name: str
    value: Any
    of: str
    why: str
    fixed_on: str


def rule(value: Any, of: str, why: str, fixed_on: str) -> Any:
    """A field of a frozen dataclass of rules.

    of         what it is a number, share or multiple of, with its unit
    why        what goes wrong with a larger or a smaller one
    fixed_on   the data on which the value was chosen
    """
    return field(default=value, metadata={"of": of, "why": why, "fixed_on": fixed_on})


def lines(rules: Any, prefix: str = "") -> Iterator[Line]:
    """Every threshold of a group of rules and of the groups in it."""
    for f in fields(rules):
        value = getattr(rules, f.name)
        if is_dataclass(value):
            yield from lines(value, f"{prefix}{f.name}.")
        else:
            yield Line(f"{prefix}{f.name}", value, **f.metadata)


def in_range(rules: Any, group: str, low: float, high: float, *names: str) -> None:
    """Raises RulesError unless the named thresholds lie between the ends, these included."""
    for name in names:
        value = getattr(rules, name)
        if not low <= value <= high:
            raise RulesError(f"rules: {group}.{name} is {value:g}; it must lie between {low:g} and {high:g}")
