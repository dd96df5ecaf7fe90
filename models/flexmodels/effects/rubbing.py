"""Which speeds decide the signs of a law's dry friction: the joint's own, or its sum with the next one's."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import sympy
from sympy import Expr, Symbol

from flexmodels.effects import signals
from flexmodels.effects.effect import Effect

_SPEEDS = (signals.de, signals.beyond.de)
Sum = Mapping[Symbol, Expr]  # speed -> factor, which parameters may decide


@cache
def rubbing(effect: Effect) -> dict[Symbol, tuple[Sum, ...]]:
    """Coordinate -> the sums of motors' speeds whose signs the law's force on it takes.

    A sign of anything else, a torque or a product, is no friction that rest or a reversal hides.
    """
    found = {q: tuple(s for f in _signs(law) if (s := _sum(f))) for q, law in effect.forces.items()}
    return {q: sums for q, sums in found.items() if sums}


def _signs(law: Expr) -> list[Any]:
    """Arguments of its signs, in an order of their own."""
    return sorted({f.args[0] for f in law.atoms(sympy.sign)}, key=str)


def _sum(argument: Any) -> Sum:
    """Empty where it is no sum of speeds."""
    factors = {v: sympy.diff(argument, v) for v in _SPEEDS if v in argument.free_symbols}
    rest = sympy.expand(argument - sum(a * v for v, a in factors.items()))
    fixed = all(a.free_symbols.isdisjoint(signals.ALL) for a in factors.values())
    return factors if fixed and rest == 0 else {}
