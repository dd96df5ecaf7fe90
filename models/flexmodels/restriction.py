"""A law on some of its coordinates: a hinge that only twists keeps k[1] of the stiffness, and no more."""

from collections.abc import Set
from dataclasses import replace

from sympy import Symbol

from flexmodels.effect import Effect


def restricted(effect: Effect, present: Set[Symbol]) -> Effect:
    """The law without its forces on other coordinates, and without the parameters of those alone."""
    forces = {q: law for q, law in effect.forces.items() if q in present}
    if len(forces) == len(effect.forces):
        return effect
    used = {symbol for law in forces.values() for symbol in law.free_symbols}
    return replace(effect, forces=forces, parameters=tuple(p for p in effect.parameters if p.symbol in used))
