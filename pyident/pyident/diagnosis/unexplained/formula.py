"""A formula for a force that no law explains, as the draft of an effect file.

Symbolic regression (Operon; Burlacu, Kronberger and Kommenda 2020) of the partial residual, that is the
splines that explain the excess plus what they leave, on the signals that the splines depend on. A draft
is a proposal: its form is chosen from one set of logs and wants a citation and a physical reason before
it is used.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
import sympy
from scipy.fft import irfft

from flexmodels.coordinate import divided, joint_name
from flexmodels.robot import Robot
from pyident.diagnosis.base.projection import gain, joined
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.diagnosis.unexplained.residual_terms import Dependence
from pyident.diagnosis.unexplained.smooth import Variable, constant_columns, spline_columns, variables

MISSING = "pyoperon is missing, which finds formulas; pip install 'flexident[symbolic]'"
_OPERATIONS = "add,sub,mul,constant,variable,abs,exp,tanh,sin,cos,sqrt"
_SAMPLES = 3000
_LENGTH = 15  # nodes of a formula
_SMALL = 0.03  # of the force's rms: terms below are left out
_SIGN = "sign of the speed"
_OWN = ("e", "de", "dde", "load", "tau")


@dataclass(frozen=True)
class Draft:
    """A proposal for one equation.

    formula         of the force [N m] in signals as the logs name them
    share_percent   of the partial residual's energy, noise included
    text            of an effect file for the equation's joint, empty where none can say it: see `note`
    """

    coordinate: str
    formula: str
    share_percent: float
    text: str
    note: str = ""


def symbolic_law(examination: Examination, found: Sequence[Dependence], seed: int = 0) -> Draft | str:
    """A draft for the first equation of `found`, or the sentence that says why there is none."""
    smooth = [d for d in found if d.coordinate == found[0].coordinate and d.form in ("force", "friction")]
    if not smooth:
        return "no formula is looked for: the residual depends on no signal in a smooth way"
    if find_spec("pyoperon") is None:
        return MISSING
    robot = examination.setting.robot
    row = robot.coordinates.index(smooth[0].coordinate)
    listed = variables(robot, examination.logs, row)
    chosen = [v for d in smooth for v in listed if (v.name, v.form) == (d.on, d.form)]
    target, features = _data(examination, row, chosen)
    size = {name: float(f"{np.sqrt(np.mean(x**2)):.4g}") for name, x in features.items()}
    ratios = {name: x / size[name] for name, x in features.items()}
    terms = _tidy(_regressed(target, ratios, seed), ratios)
    missed = target - _evaluated(sympy.Add(*terms), ratios)
    share = 100 * (1 - float(np.var(missed) / np.var(target)))
    return _draft(robot, row, terms, size, share)


def partial_residual(examination: Examination, row: int, chosen: Sequence[Variable]) -> list[np.ndarray]:
    """Per log (N,): the splines of `chosen` plus the residual that they leave on the equation [N m]."""
    logs, levels, base = examination.logs, examination.levels, examination.base
    constant = constant_columns(logs, levels, row)
    X = joined([constant, *(spline_columns(v, logs, levels, row) for v in chosen)])
    x = gain(base, X).coefficients
    imitated = sum(basis[row].T @ c[row] for basis, c in zip(base.basis, X, strict=True)) @ x
    out = []
    for log, level, basis, residual in zip(logs, levels, base.basis, base.residual, strict=True):
        whole = (residual[row] + basis[row] @ imitated) * level[row]
        bins, length = log.band.bins, log.band.length
        spectrum = np.zeros(length // 2 + 1, complex)
        spectrum[:bins] = (whole[:bins] + 1j * whole[bins:]) * np.sqrt(length / 2)
        out.append(np.asarray(irfft(spectrum, length))[: len(log.part.target)])
    return out


def _data(
    examination: Examination, row: int, chosen: Sequence[Variable]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Target (S,) and the signals (S,) by name, at some of the samples that the equation uses."""
    used = np.concatenate([log.part.use[:, row] > 0 for log in examination.logs])
    target = np.concatenate(partial_residual(examination, row, chosen))
    signals = {v.name: np.concatenate(v.values) for v in chosen}
    if any(v.form == "friction" for v in chosen):
        signals[_SIGN] = np.sign(np.concatenate([log.part.motion.dq[:, row] for log in examination.logs]))
    at = np.flatnonzero(used)
    at = at[np.linspace(0, len(at) - 1, min(_SAMPLES, len(at))).astype(int)]
    return target[at], {name: values[at] for name, values in signals.items()}


def _regressed(target: np.ndarray, ratios: Mapping[str, np.ndarray], seed: int) -> sympy.Expr:
    """The force [N m] in the symbols of `_symbol`, each a signal over its rms."""
    from pyoperon.sklearn import SymbolicRegressor

    size = float(np.std(target))
    search: Any = SymbolicRegressor(
        allowed_symbols=_OPERATIONS,
        objectives=["mse", "length"],
        max_length=_LENGTH,
        population_size=300,
        generations=100,
        max_evaluations=60_000,
        optimizer_iterations=5,
        random_state=seed,
        n_threads=1,
    )
    search.fit(np.column_stack(list(ratios.values())), target / size)
    names = [f"z{i}" for i in range(len(ratios))]
    text = search.get_model_string(search.model_, 12, names=names)
    known: dict[str, Any] = {name: _symbol(signal) for name, signal in zip(names, ratios, strict=True)}
    return size * sympy.sympify(text, locals={"abs": sympy.Abs, **known})  # pyright: ignore


def _tidy(expression: sympy.Expr, ratios: Mapping[str, np.ndarray]) -> list[sympy.Expr]:
    """The terms that count, their constants rounded; a constant force belongs to the offset."""
    terms = [t for t in sympy.Add.make_args(sympy.expand(expression)) if t.free_symbols]
    rms = [float(np.sqrt(np.mean(_evaluated(t, ratios) ** 2))) for t in terms]
    whole = float(np.sqrt(np.mean(_evaluated(sympy.Add(*terms), ratios) ** 2)))
    kept = [t for t, r in zip(terms, rms, strict=True) if r > _SMALL * whole]
    return [t.xreplace({n: sympy.Float(n, 4) for n in t.atoms(sympy.Float)}) for t in kept]  # pyright: ignore


def _evaluated(expression: sympy.Expr, ratios: Mapping[str, np.ndarray]) -> np.ndarray:
    value = sympy.lambdify([_symbol(name) for name in ratios], expression, modules="numpy")
    first = next(iter(ratios.values()))
    return np.broadcast_to(np.asarray(value(*ratios.values()), float), first.shape)


def _symbol(signal: str) -> sympy.Symbol:
    return sympy.Symbol(signal, real=True)


def _draft(
    robot: Robot, row: int, terms: Sequence[sympy.Expr], size: Mapping[str, float], share: float
) -> Draft:
    own = robot.q[row]
    logged = {name: f"({name}/{size[name]:.4g})" for name in size} | {_SIGN: f"sign({own.rate(1)})"}
    formula = _written(sympy.Add(*terms), logged)
    known = {name: _in_a_law(name, own.joint) for name in size if name != _SIGN}
    unknown = [name for name, said in known.items() if said is None]
    if unknown:
        place = joint_name(own.joint)
        note = f"an effect at {place} cannot see {unknown[0]}; a law with this signal has to be put elsewhere"
        return Draft(own.name, formula, share, "", note)
    in_law = {name: f"({said} / {size[name]:.4g})" for name, said in known.items()}
    in_law[_SIGN] = f"sign({_in_a_law(own.rate(1), own.joint)})"
    acts_on = own.local
    return Draft(own.name, formula, share, _effect_file(acts_on, terms, in_law, formula))


def _in_a_law(signal: str, joint: int) -> str | None:
    """How the effect file of a joint names a signal, None where it cannot."""
    if signal == "time":
        return signal
    if "." not in signal:
        return None
    at, name = divided(signal)
    if at == joint:
        kind = name.rstrip("123")
        return (
            f"{kind}[{name.removeprefix(kind)}]"
            if kind in ("eps", "deps")
            else name
            if kind in _OWN
            else None
        )
    return f"beyond.{name}" if at == joint + 1 and name in ("e", "de", "dde") else None


def _written(expression: sympy.Expr, names: Mapping[str, str]) -> str:
    plain = {_symbol(name): sympy.Symbol(text) for name, text in names.items()}
    return sympy.sstr(expression.xreplace(plain), full_prec=False)


def _effect_file(coordinate: str, terms: Sequence[sympy.Expr], names: Mapping[str, str], formula: str) -> str:
    split = [t.as_coeff_Mul() for t in terms]
    levels = [f"level{i}" for i in range(1, len(split) + 1)]
    force = " + ".join(
        f"{level}.symbol * ({_written(rest, names)})" for level, (_, rest) in zip(levels, split, strict=True)
    )
    lines = [
        "from sympy import Abs, cos, exp, sign, sin, sqrt, tanh",
        "",
        "from flexmodels.effects.effect import Effect, Parameter",
        "from flexmodels.effects.signals import beyond, de, dde, deps, e, eps, load, tau, time",
        "",
        *(
            f'{level} = Parameter("{level}", "N.m", start={float(value):.4g})'
            for level, (value, _) in zip(levels, split, strict=True)
        ),
        "",
        "drafted = Effect(",
        '    name="drafted",',
        '    title="A force found in a residual; say here what it is",',
        f"    forces={{{coordinate}: {force}}},",
        f"    parameters=({', '.join(levels)},),",
        '    citation="symbolic regression of a residual",',
        ")",
    ]
    return "\n".join([f"# {formula} [N m]", *lines, ""])
