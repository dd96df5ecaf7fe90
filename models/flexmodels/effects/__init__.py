"""The catalogue: every law that a robot file may name."""

from collections.abc import Iterable

from flexmodels.effects import drive, friction, loading, structure, transmission
from flexmodels.effects.effect import Effect, EffectError

CATALOGUE: dict[str, Effect] = {
    effect.name: effect
    for module in (drive, friction, transmission, structure)
    for effect in loading.in_module(module)
}
BASE: dict[str, Effect] = {name: effect for name, effect in CATALOGUE.items() if effect.base}


def register(effect: Effect) -> None:
    """Add a law to the catalogue. Raises EffectError when it breaks a rule or its name is taken."""
    if CATALOGUE.get(effect.name, effect) is not effect:
        raise EffectError(f"effect {effect.name} is in the catalogue already; give yours another name")
    if effect.base:
        raise EffectError(f"effect {effect.name} must not be a base effect; leave `base` out")
    effect.check()
    CATALOGUE[effect.name] = effect


def load_effects(files: Iterable[str]) -> None:
    """Add the laws of Python files (absolute paths) to the catalogue. Raises EffectError."""
    for file in files:
        for effect in loading.of_file(file):
            register(effect)


for _effect in loading.of_packages():
    register(_effect)
