"""The state of dry friction that builds up over a travel behind each reversal (Dahl 1968)."""

from sympy import Abs, Expr, Symbol

from flexmodels.effects.effect import Parameter, State


def dahl(name: str, rate: Expr, travel: Parameter) -> State:
    """From -1 to 1: the part of the friction that has built up at this rate of what slides."""
    now = Symbol(name, real=True)
    return State(name, (rate - Abs(rate) * now) / travel.symbol)
