"""The catalogue: the laws that every robot file may name. A robot's own laws belong to it alone."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from flexmodels.effects import drive, friction, loading, structure, transmission
from flexmodels.effects.effect import Effect
from flexmodels.effects.law_names import EffectError


def _checked(effects: Iterable[Effect], taken: Mapping[str, Effect]) -> dict[str, Effect]:
    """Effects by name. Raises EffectError when one breaks a rule or its name is taken."""
    found: dict[str, Effect] = {}
    for effect in effects:
        if (taken | found).get(effect.name, effect) is not effect:  # pyright: ignore[reportOperatorIssue]
            raise EffectError(f"effect {effect.name} is in the catalogue already; give yours another name")
        if effect.base:
            raise EffectError(f"effect {effect.name} must not be a base effect; leave `base` out")
        effect.check()
        found[effect.name] = effect
    return found


def _catalogue() -> dict[str, Effect]:
    modules = (drive, friction, transmission, structure)
    ours = {effect.name: effect for module in modules for effect in loading.in_module(module)}
    return ours | _checked(loading.of_packages(), ours)


CATALOGUE: Mapping[str, Effect] = MappingProxyType(_catalogue())
BASE: Mapping[str, Effect] = MappingProxyType({n: effect for n, effect in CATALOGUE.items() if effect.base})


def effects_of(files: Iterable[str]) -> dict[str, Effect]:
    """The laws that Python files (absolute paths) define; the files run. Raises EffectError."""
    return _checked((effect for file in files for effect in loading.of_file(file)), CATALOGUE)
