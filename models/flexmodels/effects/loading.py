"""Effects from outside the package: Python files, and the entry points of installed packages."""

import importlib.util
from collections.abc import Iterator
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from flexmodels.effects.effect import Effect, EffectError

GROUP = "flexident.effects"


@cache
def of_file(path: str) -> tuple[Effect, ...]:
    """The effects that a Python file assigns to names of its own. Raises EffectError."""
    spec = importlib.util.spec_from_file_location(f"flexident_effects_{Path(path).stem}", path)
    if spec is None or spec.loader is None or not Path(path).is_file():
        raise EffectError(f"effects: there is no Python file {path}")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise EffectError(f"effects: {path} cannot be read ({type(error).__name__}: {error})") from None
    found = tuple(in_module(module))
    if not found:
        raise EffectError(f"effects: {path} defines no Effect")
    return found


def of_packages() -> Iterator[Effect]:
    """What installed packages offer under the entry point group `flexident.effects`: effects or modules."""
    for point in entry_points(group=GROUP):
        offered = point.load()
        yield from (offered,) if isinstance(offered, Effect) else in_module(offered)


def in_module(module: Any) -> Iterator[Effect]:
    return (effect for effect in vars(module).values() if isinstance(effect, Effect))
