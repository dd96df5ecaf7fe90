"""Every public name of the documented modules has a docstring and stands on a page, or the build warns."""

import importlib
import inspect
from collections.abc import Iterator
from typing import Any

from sphinx.util import logging

MODULES = ("pyident", "flexmodels.effects.effect", "flexmodels.effects.signals")
_log = logging.getLogger(__name__)


def setup(app: Any) -> dict[str, bool]:
    app.connect("env-check-consistency", _check)
    return {"parallel_read_safe": True}


def _check(app: Any, env: Any) -> None:
    objects = env.get_domain("py").objects
    for module in MODULES:
        for name, value in public(module):
            full = f"{module}.{name}"
            if full not in objects:
                _log.warning("public name %s is on no page of the reference", full)
            for place, inner in [(full, value), *_methods(full, value)]:
                if not inspect.getdoc(inner):
                    _log.warning("public name %s has no docstring", place)


def public(module: str) -> Iterator[tuple[str, Any]]:
    """Functions and classes that a module offers: those of `__all__`, else those that it defines."""
    loaded = importlib.import_module(module)
    names = getattr(loaded, "__all__", None)
    for name in names if names is not None else vars(loaded):
        value = getattr(loaded, name)
        own = names is not None or getattr(value, "__module__", None) == module
        if own and not name.startswith("_") and callable(value):
            yield name, value


def _methods(full: str, value: Any) -> Iterator[tuple[str, Any]]:
    if inspect.isclass(value) and value.__module__.startswith(("pyident", "flexmodels")):
        for name, inner in vars(value).items():
            if not name.startswith("_") and (inspect.isfunction(inner) or isinstance(inner, property)):
                yield f"{full}.{name}", inner
