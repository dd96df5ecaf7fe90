"""One physical law, declared once; the FMU's C and the columns of Phi are derived from it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any

import sympy
from sympy import Expr, Symbol

from flexmodels import signals


@dataclass(frozen=True)
class Parameter:
    """A coefficient of a law. `unit` is for a revolute joint; a slider reads m and N instead."""

    name: str
    unit: str
    start: float = 0.0
    lower: float = -inf
    upper: float = inf

    @property
    def symbol(self) -> Symbol:
        return Symbol(self.name, real=True)


@dataclass(frozen=True)
class Effect:
    """A law for the generalised force that a joint takes from its motor or its deformations.

    forces    coordinate (signals.e or signals.eps[i]) -> expression, on the left of the paper's eq. (8)
    base      its parameters carry no effect name (`joint1.coulomb`, not `joint1.coulomb.coulomb`)
    """

    name: str
    title: str
    forces: Mapping[Symbol, Expr]
    parameters: tuple[Parameter, ...]
    citation: str
    base: bool = False
    needs: str = ""
    confounders: tuple[str, ...] = ()
    experiment: str = ""

    @cached_property
    def columns(self) -> dict[str, dict[Symbol, Expr]]:
        """parameter name -> coordinate -> d(force)/d(parameter), of the linear parameters."""
        return {p.name: self._column(p) for p in self.parameters if self._is_linear(p)}

    @cached_property
    def switches(self) -> tuple[Expr, ...]:
        """The arguments of sign and abs: where the law's form changes."""
        found: list[Any] = [
            f.args[0] for law in self.forces.values() for f in law.atoms(sympy.sign, sympy.Abs)
        ]
        return tuple(dict.fromkeys(a for a in found if not isinstance(a, sympy.sign)))

    @property
    def holds_still(self) -> bool:
        """Whether the law can hold a motor hinge at rest (dry friction: a jump at zero speed)."""
        law = self.forces.get(signals.e, sympy.S.Zero)
        return bool(law.has(sympy.sign(signals.de)))

    @property
    def latex(self) -> str:
        return r" \\ ".join(sympy.latex(law) for law in self.forces.values())

    def _column(self, parameter: Parameter) -> dict[Symbol, Expr]:
        slopes = {q: sympy.diff(law, parameter.symbol) for q, law in self.forces.items()}
        return {q: slope for q, slope in slopes.items() if slope != 0}

    def _is_linear(self, parameter: Parameter) -> bool:
        symbol = parameter.symbol
        return all(sympy.diff(law, symbol, 2) == 0 for law in self.forces.values())
