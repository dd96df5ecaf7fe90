"""The functions that a law may use: the FMU's C, Φ and the derivatives of both know these and no others."""

from collections.abc import Iterable
from typing import Any

import sympy
from sympy.core.function import AppliedUndef
from sympy.functions.elementary.piecewise import ExprCondPair

from flexmodels.effects.law_names import EffectError

FUNCTIONS = ("sin", "cos", "exp", "tanh", "sqrt", "Abs", "sign", "Min", "Max")
_NUMBERS = (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo, sympy.I)


def check_functions(effect: str, laws: Iterable[Any]) -> None:
    """Raises EffectError where a law uses a function that is not among these, or a number that is none."""
    for law in map(sympy.sympify, laws):
        for part in sympy.preorder_traversal(law):
            name = _function(part)
            if name is not None and name not in FUNCTIONS:
                known = ", ".join(FUNCTIONS)
                raise EffectError(f"effect {effect} uses {name}, which the FMU does not have; it has {known}")
            if part in _NUMBERS:
                raise EffectError(f"effect {effect}: {law} holds {part}, which is no number to compute with")


def _function(part: Any) -> str | None:
    """Name of the function that a node of an expression applies, None for sums, products and powers."""
    if isinstance(part, AppliedUndef | sympy.Function | sympy.Max | sympy.Min):
        return type(part).__name__
    if isinstance(part, sympy.core.relational.Relational | ExprCondPair | sympy.Derivative | sympy.Integral):
        return type(part).__name__
    return None
