"""One physical law, declared once; the FMU's C and the columns of Phi are derived from it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from typing import Any

import sympy
from sympy import Expr, Symbol

from flexmodels.effects import signals
from flexmodels.effects.functions import check_functions
from flexmodels.effects.law_names import EffectError, check_names

SLOW = 0.01  # [rad/s or m/s] over which a sign of any other speed than the joint's own is rounded


@dataclass(frozen=True)
class Parameter:
    """A coefficient of a law. `unit` is for a revolute joint; a slider reads m and N instead.

    grid    values that a search tries first; what has one enters its law nonlinearly, and nothing else does
    scale   signal in whose root mean square the grid is counted; none: the grid is in `unit`, unless it is
    across  a signal's range in the logs: 0 is its lowest value, 1 its highest
    between this joint and the next, if one slides: the grid is in the rms of one signal per the other's
    periodic  whether it counts the law's periods per turn of the joint; a law has one such parameter at most
    usual   its value where nothing is known, in base parameters (Symbol("k[1]")); None: as large as is asked
    """

    name: str
    unit: str
    start: float = 0.0
    lower: float = -inf
    upper: float = inf
    grid: tuple[float, ...] = ()
    scale: Symbol | None = None
    across: Symbol | None = None
    between: tuple[Symbol, Symbol] | None = None
    periodic: bool = False
    usual: Any = None

    @property
    def symbol(self) -> Symbol:
        """As it stands in an expression."""
        return Symbol(self.name, real=True)

    @property
    def linear(self) -> bool:
        """Whether it has a column of Φ."""
        return not self.grid


@dataclass(frozen=True)
class State:
    """Memory of a law: `rate`, its time derivative, is affine in it; start None: where the rate is zero."""

    name: str
    rate: Expr
    start: float | None = 0.0
    unit: str = "1"

    @property
    def symbol(self) -> Symbol:
        """As it stands in an expression."""
        return Symbol(self.name, real=True)

    @cached_property
    def coefficients(self) -> tuple[Expr, Expr]:
        """a and b of rate = a * state + b."""
        slope = sympy.diff(self.rate, self.symbol)
        return slope, self.rate.subs(self.symbol, 0)


@dataclass(frozen=True)
class Coverage:
    """What the samples of a log must show: `condition` of signals and parameters in a `share` of them."""

    condition: Any
    share: float


@dataclass(frozen=True, eq=False)
class Effect:
    """A law for the generalised force that a joint takes from its motor or its deformations.

    forces      coordinate (signals.e, signals.eps[i] or signals.beyond.e) -> expression, on the left of
                the paper's eq. (8); linear in the accelerations dde and beyond.dde
    body        parameter of a link (`m`, `ms[x]`, `J[xy]`) -> expression in the parameters and signals.tip:
                what the law adds to the body of the robot's last link
    states      the law's memory
    base        its parameters carry no effect name (`joint1.coulomb`, not `joint1.coulomb.coulomb`)
    turning     acts at a revolute joint only
    excess_over effect on top of which it comes: a diagnosis proposes it only where that one acts already
    proper      condition on its parameters, the joint's base parameters (Symbol("k[1]")) and signals.period,
                without which the values found are no such effect: a gap that takes little of the stiffness
                is no backlash
    sized_by    name of the parameter that makes it a large or a small one; none: its first linear one
    needs, coverage   what a log must contain, in words and where it is simple as a condition
    confounders       effects of the catalogue and base parameters that look alike
    experiment        the motion that separates them
    """

    name: str
    title: str
    forces: Mapping[Symbol, Expr]
    parameters: tuple[Parameter, ...]
    citation: str
    states: tuple[State, ...] = ()
    body: Mapping[str, Expr] = field(default_factory=dict)
    base: bool = False
    turning: bool = False
    excess_over: str = ""
    proper: Any = None
    sized_by: str = ""
    needs: str = ""
    coverage: Coverage | None = None
    confounders: tuple[str, ...] = ()
    experiment: str = ""

    @cached_property
    def laws(self) -> dict[Symbol, Expr]:
        """`forces`, with the sign of a foreign or combined speed rounded: sign(v) becomes tanh(v/SLOW)."""
        return {q: _rounded(law) for q, law in self.forces.items()}

    @cached_property
    def columns(self) -> dict[str, dict[Symbol, Expr]]:
        """parameter name -> coordinate -> d(force)/d(parameter), of the linear parameters."""
        return {name: _present(slopes) for name, slopes in self._slopes(self.laws).items()}

    @cached_property
    def body_columns(self) -> dict[str, dict[str, Expr]]:
        """parameter name -> parameter of the link -> its derivative, of the linear parameters."""
        return {name: _present(slopes) for name, slopes in self._slopes(self.body).items()}

    @property
    def linear(self) -> tuple[Parameter, ...]:
        """Parameters of which the law is a weighted sum."""
        return tuple(p for p in self.parameters if p.linear)

    @property
    def nonlinear(self) -> tuple[Parameter, ...]:
        """Parameters that enter in any other way."""
        return tuple(p for p in self.parameters if not p.linear)

    @property
    def size(self) -> Parameter:
        """The parameter that makes the effect a large or a small one."""
        return next((p for p in self.parameters if p.name == self.sized_by), self.linear[0])

    @property
    def order(self) -> Parameter | None:
        """The parameter that counts the law's periods per turn, None where the law is not periodic."""
        return next((p for p in self.parameters if p.periodic), None)

    @property
    def order_of_torque(self) -> Parameter | None:
        """`order`, but of friction None: that is friction however slowly it changes along the range."""
        return None if self.is_friction else self.order

    @cached_property
    def expressions(self) -> tuple[Expr, ...]:
        """Everything that the law computes: its forces and the rates of its states."""
        return (*self.laws.values(), *(state.rate for state in self.states))

    @cached_property
    def symbols(self) -> frozenset[Symbol]:
        """Every signal, parameter and state that the law reads or acts on."""
        bodies = tuple(self.body.values())
        found = {s for law in (*self.expressions, *bodies) for s in law.free_symbols}
        return frozenset(found) | frozenset(self.forces)  # pyright: ignore

    @cached_property
    def switches(self) -> tuple[Expr, ...]:
        """The arguments of sign and abs: where the law's form changes."""
        found: list[Any] = [f.args[0] for law in self.expressions for f in law.atoms(sympy.sign, sympy.Abs)]
        return tuple(dict.fromkeys(a for a in found if not isinstance(a, sympy.sign)))

    @property
    def holds_still(self) -> bool:
        """Whether the law can hold a motor hinge at rest (dry friction: a jump at zero speed)."""
        law = self.forces.get(signals.e, sympy.S.Zero)
        return bool(law.has(sympy.sign(signals.de)))

    @cached_property
    def is_friction(self) -> bool:
        """Whether the law acts on the motor hinge alone, without memory, and makes no torque at rest.

        Such a law can only take power: what gives some has a store, or a supply, and acts at rest as well.
        """
        if set(self.forces) != {signals.e} or self.states:
            return False
        return self.forces[signals.e].subs(signals.de, 0) == 0

    @property
    def has_modes(self) -> bool:
        """Whether the law changes its form where the joint reverses."""
        return signals.de in self.switches

    @property
    def couples(self) -> bool:
        """Whether the law reads or moves the next joint."""
        return not self.symbols.isdisjoint(signals.beyond)

    @property
    def latex(self) -> str:
        """Forces, rates of states and additions to the body, line by line."""
        rates = (rf"\dot{{{s.name}}} = {sympy.latex(s.rate)}" for s in self.states)
        bodies = (
            rf"{sympy.latex(Symbol(name))} \mathrel{{+}}= {sympy.latex(x)}" for name, x in self.body.items()
        )
        return r" \\ ".join([*(sympy.latex(law) for law in self.forces.values()), *rates, *bodies])

    def check(self) -> None:
        """Raises EffectError when the law breaks a rule of this file."""
        check_names(
            self.name, {p.name: p.unit for p in self.parameters}, {s.name: s.unit for s in self.states}
        )
        check_functions(
            self.name, (*self.forces.values(), *self.body.values(), *(s.rate for s in self.states))
        )
        periods = [p.name for p in self.parameters if p.periodic]
        if len(periods) > 1 or any(p.periodic and p.linear for p in self.parameters):
            raise EffectError(
                f"effect {self.name}: one parameter with a grid may be periodic, not {', '.join(periods)}"
            )
        if self.sized_by and self.size.name != self.sized_by:
            raise EffectError(f"effect {self.name} has no parameter {self.sized_by} to be sized by")
        coordinates = {signals.e, *signals.eps.values(), signals.beyond.e}
        known = {p.symbol for p in self.parameters} | {s.symbol for s in self.states}
        for name in {str(q) for q in set(self.forces) - coordinates}:
            raise EffectError(f"effect {self.name} puts a force on {name}; use e, eps[i] or beyond.e")
        for symbol in self.symbols - known - signals.ALL:
            raise EffectError(f"effect {self.name} uses {symbol}, which is no signal, parameter or state")
        for state in self.states:
            if sympy.diff(state.rate, state.symbol, 2) != 0:
                raise EffectError(f"effect {self.name}: the rate of {state.name} must be affine in it")
        for law in self.laws.values():
            for a in (signals.dde, signals.beyond.dde):
                if sympy.diff(law, a).has(signals.dde, signals.beyond.dde):
                    raise EffectError(f"effect {self.name} must be linear in the acceleration {a}")
        _ = self.columns, self.body_columns

    def _slopes(self, laws: Mapping[Any, Expr]) -> dict[str, dict[Any, Expr]]:
        """d(law)/d(parameter); raises EffectError unless every law is a sum of parameter times slope."""
        slopes: dict[Parameter, dict[Any, Any]] = {
            p: {q: sympy.diff(x, p.symbol) for q, x in laws.items()} for p in self.linear
        }
        mine = {p.symbol for p in self.linear}
        for p in sorted(self.linear, key=lambda p: not any(x.has(p.symbol) for x in slopes[p].values())):
            remembered = any(s.rate.has(p.symbol) for s in self.states)
            if remembered or any(slope.free_symbols & mine for slope in slopes[p].values()):
                raise EffectError(
                    f"effect {self.name} is not linear in its parameter {p.name}; parameters that enter "
                    "nonlinearly need a grid"
                )
        if any(law.subs(dict.fromkeys(mine, 0)) != 0 for law in laws.values()):
            raise EffectError(f"effect {self.name} must vanish when its linear parameters are zero")
        return {p.name: slopes[p] for p in self.linear}


def sheet(effect: Effect) -> dict[str, str]:
    """What is known of a law, a line each, in reading order."""
    adds = [f"{name} += {x}" for name, x in effect.body.items()]
    rates = [f"{s.name}' = {s.rate}" for s in effect.states]
    lines = {
        "force": "\n".join([*(f"on {q}: {law}" for q, law in effect.forces.items()), *rates, *adds]),
        "parameters": "\n".join(_line(p) for p in effect.parameters),
        "citation": effect.citation,
        "needs": effect.needs,
        "confounders": ", ".join(effect.confounders),
        "experiment": effect.experiment,
    }
    return {key: text for key, text in lines.items() if text}


def _line(p: Parameter) -> str:
    limits = "" if p.lower == -inf and p.upper == inf else f", from {p.lower:g} to {p.upper:g}"
    unit = p.unit
    if p.scale is not None:
        unit = f"rms of {p.scale}"
    elif p.across is not None:
        unit = f"of the range of {p.across}"
    tried = "" if p.linear else f"; nonlinear, tried at {', '.join(f'{v:g}' for v in p.grid)} [{unit}]"
    return f"{p.name} [{p.unit}]{limits}{tried}"


def _present(slopes: dict[Any, Expr]) -> dict[Any, Expr]:
    return {q: slope for q, slope in slopes.items() if slope != 0}


def _rounded(law: Expr) -> Expr:
    speeds = {signals.de, signals.beyond.de, *signals.deps.values()}

    def foreign(f: Any) -> bool:
        return isinstance(f, sympy.sign) and f.args[0] != signals.de and bool(f.free_symbols & speeds)

    return law.replace(foreign, lambda f: sympy.tanh(f.args[0] / SLOW))  # pyright: ignore
