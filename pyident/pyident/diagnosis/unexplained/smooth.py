"""Forces that no law names, as smooth functions of one signal: additive splines on one equation.

A force f(x), or a friction sign(v) f(x), is a sum of B-splines of x. Their columns go through the same
transform, floor and projection as those of a law, so what they explain is comparable with what a law
would.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import BSpline

from flexmodels.coordinate import divided
from flexmodels.robot import Robot
from pyident.diagnosis.base.projection import Columns
from pyident.regression.laws import Signals
from pyident.regression.spectrum import Equations
from pyident.rules.stillness import stands_still

SPLINES = 15  # per signal; one is lost to the constant
_DEGREE = 3

Form = Literal["force", "friction"]


@dataclass(frozen=True)
class Variable:
    """A signal that a force may depend on.

    name     as a law would call it behind `joint{k}.`; words: as a sentence would
    form     `force` f(x), `friction` sign(v) f(x) with the speed v of the equation's own coordinate
    values   per log (N,), SI units
    """

    name: str
    words: str
    form: Form
    values: tuple[np.ndarray, ...]

    @property
    def knots(self) -> np.ndarray:
        """Of cubic splines, one more at each end than quantiles between."""
        x = np.concatenate(self.values)
        inner = np.unique(np.quantile(x, np.linspace(0, 1, SPLINES - _DEGREE + 1)))
        return np.concatenate([[inner[0]] * _DEGREE, inner, [inner[-1]] * _DEGREE])

    def splines(self, x: np.ndarray) -> np.ndarray:
        """(len(x), K)"""
        t = self.knots
        inside = np.clip(x, t[0], t[-1])
        return np.asarray(BSpline.design_matrix(inside, t, _DEGREE).toarray())


def variables(robot: Robot, logs: Sequence[Equations], row: int) -> list[Variable]:
    """Every signal of every joint, time, and the travel since the last reversal, for one equation.

    But for the motor's own torque, which the equation has on its other side and which explains any residual,
    and for accelerations, which a missing torque makes itself.
    """
    found = []
    signals = [Signals(robot, log.part.motion).after for log in logs]
    own_torque = f"{robot.coordinates[row].split('.')[0]}.tau"
    for name in signals[0]:
        if name == own_torque or ".dd" in name:
            continue
        found.append((name, words_of(name), tuple(np.asarray(s[name], float) for s in signals)))
    speeds = [log.part.motion.dq[:, row] for log in logs]
    travel = tuple(_travel(log.part.motion.q[:, row], v) for log, v in zip(logs, speeds, strict=True))
    found.append(("travel", "travel since the last reversal", travel))
    largest: dict[str, float] = {}
    for name, _, values in found:
        of_kind = [largest.get(_kind(name), 0.0), *(float(np.abs(x).max()) for x in values)]
        largest[_kind(name)] = max(of_kind)
    return [
        Variable(name, words, form, values)
        for name, words, values in found
        if not stands_still(*values, beside=largest[_kind(name)])
        for form in ("force", "friction")
    ]


def spline_columns(
    variable: Variable, logs: Sequence[Equations], levels: Sequence[np.ndarray], row: int
) -> Columns:
    """Per log: row -> (E, K) whitened columns of the splines, without their constant."""
    raw = [variable.splines(x) for x in variable.values]
    mean = np.concatenate(raw).mean(axis=0)
    shaped = []
    for log, B in zip(logs, raw, strict=True):
        centred = B - mean
        if variable.form == "friction":
            centred = np.sign(log.part.motion.dq[:, row])[:, None] * centred
        shaped.append(centred)
    return whitened_columns(shaped, logs, levels, row)


def constant_columns(logs: Sequence[Equations], levels: Sequence[np.ndarray], row: int) -> Columns:
    """Per log: row -> (E, 1) of a constant force."""
    return whitened_columns([np.ones((len(log.part.target), 1)) for log in logs], logs, levels, row)


def whitened_columns(
    raw: Sequence[np.ndarray], logs: Sequence[Equations], levels: Sequence[np.ndarray], row: int
) -> Columns:
    """Columns (N, K) per log on one equation, as `evidence.gain` takes them."""
    return [
        {row: log.band.transform(log.part.used(row, X.T).T) / level[row][:, None]}
        for X, log, level in zip(raw, logs, levels, strict=True)
    ]


def curve(variable: Variable, coefficients: np.ndarray, points: int = 101) -> tuple[np.ndarray, np.ndarray]:
    """x and f(x), (points,): the force between its 1st and 99th percentile, zero on average."""
    data = np.concatenate(variable.values)
    low, high = np.quantile(data, [0.01, 0.99]).tolist()
    x = np.linspace(low, high, points)
    mean = variable.splines(data).mean(axis=0)
    return x, (variable.splines(x) - mean) @ coefficients


def words_of(name: str) -> str:
    """`joint2.de` is the speed of joint 2."""
    if name == "time":
        return "time"
    joint, signal = divided(name)
    said = {"e": "position", "de": "speed", "tau": "torque", "load": "load"}
    rates = {"eps": "deformation", "deps": "deformation rate"}
    kind = signal.rstrip("123")
    number = signal.removeprefix(kind)
    what = said[signal] if signal in said else f"{rates[kind]} {number}"
    return f"{what} of joint {joint}"


def _kind(name: str) -> str:
    """`de` of `joint2.de`, `eps` of `joint1.eps3`: signals of one kind are compared by size."""
    return name.rpartition(".")[2].rstrip("123")


def _travel(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """|q − q at the last reversal|, (N,)."""
    turning = np.concatenate([[True], v[1:] * v[:-1] < 0])
    last = np.maximum.accumulate(np.where(turning, np.arange(len(q)), 0))
    return np.abs(q - q[last])
