"""What a reader of a page must know of a law: formula, source, what shows it and what separates it."""

from dataclasses import dataclass

from latex2mathml.converter import convert
from markupsafe import Markup
from sympy import Expr, Symbol, latex

from flexmodels.effects import signals
from flexmodels.effects.effect import Effect
from pyident.report.wording import unit

_PLACES = {
    signals.e: "on the motor hinge",
    signals.eps[1]: "on the drive's twist ε₁",
    signals.eps[2]: "on the bending ε₂",
    signals.eps[3]: "on the bending ε₃",
    signals.beyond.e: "on the next joint's motor hinge",
}
_SIGNALS = {
    signals.e: "e",
    signals.de: r"\dot{e}",
    signals.dde: r"\ddot{e}",
    signals.tau: r"\tau",
    signals.load: r"\tau_\text{load}",
    signals.time: "t",
    signals.beyond.e: r"e_\text{next}",
    signals.beyond.de: r"\dot{e}_\text{next}",
    signals.beyond.dde: r"\ddot{e}_\text{next}",
    signals.tip.x: r"x_\text{tip}",
    signals.tip.y: r"y_\text{tip}",
    signals.tip.z: r"z_\text{tip}",
    **{s: rf"\varepsilon_{i}" for i, s in signals.eps.items()},
    **{s: rf"\dot{{\varepsilon}}_{i}" for i, s in signals.deps.items()},
}


@dataclass(frozen=True)
class Formula:
    """Where the law acts or what it computes, and the formula as MathML."""

    place: str
    mathml: Markup


@dataclass(frozen=True)
class Sheet:
    """One law; parameters are names with their units."""

    name: str
    title: str
    formulas: tuple[Formula, ...]
    parameters: tuple[tuple[str, str], ...]
    citation: str
    needs: str
    confounders: tuple[str, ...]
    experiment: str


def law_sheet(effect: Effect) -> Sheet:
    """The sheet of one effect."""
    return Sheet(
        name=effect.name,
        title=effect.title,
        formulas=tuple(_formulas(effect)),
        parameters=tuple((p.name, unit(p.unit)) for p in effect.parameters),
        citation=effect.citation,
        needs=effect.needs,
        confounders=effect.confounders,
        experiment=effect.experiment,
    )


def _formulas(effect: Effect) -> list[Formula]:
    places: dict[Expr, list[str]] = {}
    for coordinate, law in effect.forces.items():
        places.setdefault(law, []).append(_PLACES[coordinate])
    found = [Formula(" and ".join(where), _mathml(law)) for law, where in places.items()]
    for state in effect.states:
        left = rf"\frac{{d}}{{dt}}\,{_plain(state.name)}"
        found.append(Formula(f"memory {state.name}", _mathml(state.rate, f"{left} = ")))
    for name, more in effect.body.items():
        found.append(Formula(f"added to {name} of the last link", _mathml(more)))
    return found


def _mathml(law: Expr, left: str = "") -> Markup:
    names = {s: _SIGNALS.get(s, _plain(s.name)) for s in law.free_symbols if isinstance(s, Symbol)}
    return Markup(convert(left + latex(law, symbol_names=names, mul_symbol=r"\,")))


def _plain(name: str) -> str:
    """A name set upright, in one piece."""
    escaped = name.replace("_", r"\_")
    return rf"\text{{{escaped}}}"
