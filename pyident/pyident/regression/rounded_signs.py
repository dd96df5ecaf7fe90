"""Signs of measured speeds: near rest they are noise, and a law takes their mean.

If a speed's error is uniform in ± w, the mean of f(v) is (F(v + w) − F(v − w)) / 2w with F' = f. For the
sign, F = |v|: the mean is v / w within the dead zone and ± 1 beyond. For a sign that the law itself rounds,
tanh, F is the logarithm of the hyperbolic cosine.
"""

from functools import cache
from typing import Any

import sympy
from sympy import Abs, Expr, exp, log, sign, tanh

from flexmodels.effects import signals

_SPEEDS = (signals.de, signals.beyond.de)
_INTEGRALS = {sign: Abs, tanh: lambda x: Abs(x) + log(1 + exp(-2 * Abs(x)))}


@cache
def blurred(law: Any, dead_zone: float) -> Expr:
    """A law whose signs of speeds are means over an error of ± dead_zone [rad/s or m/s]."""
    if not dead_zone:
        return law
    found = {f for f in law.atoms(*_INTEGRALS) if f.free_symbols & set(_SPEEDS)}
    return law.xreplace({f: _mean(f, dead_zone) for f in found})


def _mean(function: Any, dead_zone: float) -> Expr:
    (argument,) = function.args
    speed = next(v for v in _SPEEDS if v in argument.free_symbols)
    width = dead_zone * Abs(sympy.diff(argument, speed))
    integral = _INTEGRALS[function.func]
    return (integral(argument + width) - integral(argument - width)) / (2 * width)
