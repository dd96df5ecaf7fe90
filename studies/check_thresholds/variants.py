"""A group of thresholds with one of them halved or doubled."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from typing import Any

FACTORS = {"half": 0.5, "twice": 2.0}


@dataclass(frozen=True)
class Variant:
    """A threshold and what it is multiplied by; no name: the rules as they are."""

    group: str = ""
    name: str = ""
    factor: str = ""

    def __str__(self) -> str:
        return f"{self.group}.{self.name} {self.factor}" if self.name else "as they are"


def variants(groups: Mapping[str, Any]) -> Iterator[Variant]:
    """The rules as they are, then each threshold of the groups halved and doubled."""
    yield Variant()
    for group, rules in groups.items():
        for field in fields(rules):
            for factor in FACTORS:
                yield Variant(group, field.name, factor)


@contextmanager
def in_force(variant: Variant, groups: Mapping[str, Any]) -> Iterator[None]:
    """While it lasts, this process goes by the changed threshold. Raises RulesError.

    What asks these groups is not told its rules, so the only object of the group is changed and put back.
    """
    if not variant.name:
        yield
        return
    rules = groups[variant.group]
    value = getattr(rules, variant.name)
    changed = getattr(replace(rules, **{variant.name: _scaled(value, FACTORS[variant.factor])}), variant.name)
    object.__setattr__(rules, variant.name, changed)
    try:
        yield
    finally:
        object.__setattr__(rules, variant.name, value)


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, tuple):
        return tuple(factor * x for x in value)
    return max(1, round(factor * value)) if isinstance(value, int) else factor * value
