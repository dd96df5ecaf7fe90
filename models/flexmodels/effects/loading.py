"""Effects from outside the package: Python files, and the entry points of installed packages."""

import hashlib
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from flexmodels.effects.effect import Effect
from flexmodels.effects.law_names import EffectError

GROUP = "flexident.effects"


_known: dict[str, tuple[Effect, ...]] = {}  # SHA-256 of a file's content -> its effects


def of_file(path: str) -> tuple[Effect, ...]:
    """The effects that a Python file assigns to names of its own. Raises EffectError.

    Files of the same content have the same effects, wherever they lie; the content runs once.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise EffectError(f"effects: {path} cannot be read ({error.strerror})") from None
    digest = hashlib.sha256(content).hexdigest()
    if digest not in _known:
        _known[digest] = _run(content, path)
    return _known[digest]


def _run(content: bytes, path: str) -> tuple[Effect, ...]:
    module = ModuleType(f"flexident_effects_{Path(path).stem}")
    module.__file__ = path
    try:
        exec(compile(content, path, "exec"), module.__dict__)
    except (Exception, SystemExit) as error:
        raise EffectError(f"effects: {path} cannot be read ({_one_line(error)})") from None
    found = tuple(in_module(module))
    if not found:
        raise EffectError(f"effects: {path} defines no Effect")
    return found


def of_packages() -> Iterator[Effect]:
    """What installed packages offer under the entry point group `flexident.effects`: effects or modules."""
    for point in entry_points(group=GROUP):
        offered = point.load()
        yield from (offered,) if isinstance(offered, Effect) else in_module(offered)


def _one_line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def in_module(module: Any) -> Iterator[Effect]:
    """The laws that a module names at its top."""
    return (effect for effect in vars(module).values() if isinstance(effect, Effect))
