"""The catalogue: every law that a robot file may name."""

from flexmodels.effect import Effect
from flexmodels.effects import drive, friction, transmission

CATALOGUE: dict[str, Effect] = {
    effect.name: effect
    for module in (drive, friction, transmission)
    for effect in vars(module).values()
    if isinstance(effect, Effect)
}
BASE: dict[str, Effect] = {name: effect for name, effect in CATALOGUE.items() if effect.base}
