"""The symbols that a law may use; all SI, all of the law's own joint unless named otherwise.

e, de, dde   motor hinge angle [rad] or slider position [m] and its derivatives
eps, deps    the three deformations of the flexible hinge [rad] and their rates; index 1, 2, 3
tau          motor torque [N m or N]
load         torque that the transmission carries [N m]
time         [s]
"""

from sympy import Symbol

e = Symbol("e", real=True)
de = Symbol("de", real=True)
dde = Symbol("dde", real=True)
eps = {i: Symbol(f"eps{i}", real=True) for i in (1, 2, 3)}
deps = {i: Symbol(f"deps{i}", real=True) for i in (1, 2, 3)}
tau = Symbol("tau", real=True)
load = Symbol("load", real=True)
time = Symbol("time", real=True)


def of_joint(joint: int, signal: Symbol) -> Symbol:
    """`signal` of another joint, counted from 1."""
    return Symbol(f"joint{joint}.{signal.name}", real=True)
