"""The functions of a plant as C: what is generated, with which arguments, into which file."""

from dataclasses import dataclass

import casadi as ca

from flexfmu.code.c_code import c_function, prototype
from flexmodels.mechanics.plant import Equations


@dataclass(frozen=True)
class Generated:
    """A CasADi function and the names of its C arguments."""

    name: str
    function: ca.Function
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @property
    def c(self) -> str:
        return c_function(self.function, self.name, self.inputs, self.outputs)

    @property
    def prototype(self) -> str:
        takes = prototype(self.name, self.inputs, self.outputs)
        return takes.replace(f"NAME({self.name})", f"model_{self.name}").replace("real ", "double ")


def inner(eq: Equations) -> list[Generated]:
    """What every step of the solver needs; also compiled for many runs at once."""
    return [
        Generated("rates", eq.rates, ("x", "u", "p", "mode"), ("dx", "imbalance", "friction")),
        Generated("breakaway", eq.breakaway, ("x", "u", "p", "mode"), ("upper", "lower")),
    ]


def outer(eq: Equations) -> list[Generated]:
    """What a communication step or the start needs."""
    x, dx = eq.shown.sx_in()[0], ca.SX.sym("dx", eq.shown.numel_in(0))
    slope = ca.Function("shown_rate", [x, dx], [ca.jtimes(eq.shown(x), x, dx)])
    return [
        Generated("laws", eq.laws, ("x", "u", "p", "mode", "dx"), ("force",)),
        Generated("balance", eq.balance, ("x", "p"), ("force",)),
        Generated("start", eq.start, ("x", "u", "p"), ("z",)),
        Generated("pivots", eq.pivots, ("x", "p"), ("d",)),
        Generated("tip", eq.tip, ("x",), ("position",)),
        Generated("shown", eq.shown, ("x",), ("values",)),
        Generated("shown_rate", slope, ("x", "dx"), ("values",)),
    ]


def derivatives(eq: Equations) -> list[Generated]:
    """Jacobian products, forward and reverse, of all that follows from state, torque and parameters."""
    x, u, p, mode = eq.rates.sx_in()
    results = everything(eq)
    seeds = [ca.SX.sym(f"seed{i}", v.numel()) for i, v in enumerate((x, u, p))]
    y, known = results(x, u, p, mode), ca.vertcat(x, u, p)
    weight = ca.SX.sym("weight", y.numel())
    pulled = ca.vertsplit(
        ca.jtimes(y, known, weight, True), [0, x.numel(), x.numel() + u.numel(), known.numel()]
    )
    forward = ca.Function("f", [x, u, p, mode, *seeds], [ca.jtimes(y, known, ca.vertcat(*seeds))])
    force, start = eq.balance(x, p), eq.start(x, u, p)
    along = ca.vertcat(seeds[0], seeds[2])
    balance = ca.Function("f", [x, p, seeds[0], seeds[2]], [ca.jtimes(force, ca.vertcat(x, p), along)])
    began = ca.Function("f", [x, u, p, *seeds], [ca.jtimes(start, known, ca.vertcat(*seeds))])
    return [
        Generated("forward", forward, ("x", "u", "p", "mode", "sx", "su", "sp"), ("y",)),
        Generated(
            "adjoint",
            ca.Function("f", [x, u, p, mode, weight], pulled),
            ("x", "u", "p", "mode", "weight"),
            ("by_x", "by_u", "by_p"),
        ),
        Generated("balance_forward", balance, ("x", "p", "sx", "sp"), ("force",)),
        Generated("start_forward", began, ("x", "u", "p", "sx", "su", "sp"), ("z",)),
    ]


def everything(eq: Equations) -> ca.Function:
    """(x, u, p, mode) -> rates, imbalance, friction, upper, lower, laws, tip, shown: one after the other."""
    x, u, p, mode = eq.rates.sx_in()
    dx, imbalance, friction = eq.rates(x, u, p, mode)
    upper, lower = eq.breakaway(x, u, p, mode)
    laws = eq.laws(x, u, p, mode, dx)
    y = ca.vertcat(dx, imbalance, friction, upper, lower, laws, eq.tip(x), eq.shown(x))
    return ca.Function("everything", [x, u, p, mode], [y])
