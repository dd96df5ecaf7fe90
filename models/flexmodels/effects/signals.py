"""The symbols that a law may use; all SI, all of the law's own joint unless named otherwise.

e, de, dde   motor hinge angle [rad] or slider position [m] and its derivatives
eps, deps    the three deformations of the flexible hinge [rad] and their rates; index 1, 2, 3
tau          motor torque [N m or N]
load         torque that the transmission carries [N m or N]: k[1] eps[1] of the joint's stiffness law;
             where the joint is rigid what the links ask of it, M(q) q̈ + h(q, q̇) without the motor's inertia
time         [s] since the start
period       [s] between a log's samples, for conditions on what was found in it
beyond       e, de, dde of the next joint
tip          x, y, z of the robot's tip in its link [m], for what a law adds to that link's body
"""

from typing import NamedTuple

from sympy import Symbol


class Beyond(NamedTuple):
    """The next joint's motor: position [rad or m], speed, acceleration."""

    e: Symbol
    de: Symbol
    dde: Symbol


class Tip(NamedTuple):
    """From the last link's joint to the tip, base axes in the zero pose [m]."""

    x: Symbol
    y: Symbol
    z: Symbol


e = Symbol("e", real=True)
de = Symbol("de", real=True)
dde = Symbol("dde", real=True)
eps = {i: Symbol(f"eps{i}", real=True) for i in (1, 2, 3)}
deps = {i: Symbol(f"deps{i}", real=True) for i in (1, 2, 3)}
tau = Symbol("tau", real=True)
load = Symbol("load", real=True)
time = Symbol("time", real=True)
period = Symbol("period", positive=True)
beyond = Beyond(*(Symbol(f"beyond.{name}", real=True) for name in Beyond._fields))
tip = Tip(*(Symbol(f"tip.{name}", real=True) for name in Tip._fields))
ALL = frozenset({e, de, dde, *eps.values(), *deps.values(), tau, load, time, *beyond, *tip})
