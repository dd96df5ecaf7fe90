"""Robot + laws + controller -> Equations, the one description from which an FMU is generated.

State x = (q, v). Dry friction is written with a mode per motor hinge: +1 slides forward, -1 backward,
0 is stuck. A mode takes the place of sign(de); a stuck hinge is held at constant speed (zero) and its
friction is the reaction, found exactly for any number of stuck hinges at once.
"""

from dataclasses import dataclass

import casadi as ca
import sympy

from flexmodels import dynamics, projected, signals
from flexmodels.effect import Effect
from flexmodels.robot import LINK_PARAMETERS, Controller, Robot, parameter_name

_MODE = sympy.Symbol("mode", real=True)
_TO_CASADI = {
    "Abs": ca.fabs,
    "sign": ca.sign,
    "exp": ca.exp,
    "sqrt": ca.sqrt,
    "tanh": ca.tanh,
    "sin": ca.sin,
    "cos": ca.cos,
    "Min": ca.fmin,
    "Max": ca.fmax,
}


@dataclass(frozen=True)
class Equations:
    """A plant ready for code generation. All functions are casadi.Function of vectors, SI units.

    rates(x, u, p, mode) -> dx, imbalance, friction
                     imbalance: torque a brake must take at a stuck hinge; friction: sum of the laws at e
    breakaway(x, u, p) -> upper, lower        dry friction at zero speed, either direction
    balance(x, p) -> force                    generalised forces at rest that the motors must supply
    tip(x) -> position                        [m]
    skeleton(x) -> lines                      3 x 2 lines, from hinge to hinge and to the tip [m]
    Without a controller the torques u are inputs.
    """

    name: str
    description: str
    coordinates: tuple[str, ...]
    joints: int
    parameters: dict[str, float]
    units: dict[str, str]
    nonnegative: frozenset[str]
    sticking: tuple[bool, ...]
    prismatic: tuple[bool, ...]
    controller: Controller | None
    descriptions: dict[str, str]
    laws: tuple[tuple[int, str, str], ...]
    rates: ca.Function
    breakaway: ca.Function
    balance: ca.Function
    tip: ca.Function
    skeleton: ca.Function


def equations(robot: Robot) -> Equations:
    """The robot's equations of motion, eq. (8), with its laws and its controller."""
    if robot.controller is None:
        raise ValueError(f"robot {robot.name} has no [controller], so it cannot be simulated; add one")
    m = dynamics.mechanism(robot)
    n, joints = m.q.numel(), len(robot.joints)
    p = ca.SX.sym("p", len(robot.parameters))
    u, mode = ca.SX.sym("u", joints), ca.SX.sym("mode", joints)
    laws = _Laws(robot, m, p, u)
    q_dot, bodies = m.v, ca.reshape(p[: m.bodies.numel()], *m.bodies.shape)
    x = ca.vertcat(m.q, m.v)

    free = ca.SX.ones(n)
    for k in range(joints):
        free[k] = ca.fabs(mode[k]) if laws.sticking[k] else 1
    resisting = laws.forces(mode)
    applied = ca.vertcat(u, ca.SX.zeros(n - joints)) - resisting
    forward_dynamics = projected.forward_dynamics if robot.passive else dynamics.forward_dynamics
    a, imbalance = forward_dynamics(m, applied, laws.armature, free)
    dx, imbalance = ca.substitute([ca.vertcat(q_dot, a), imbalance[:joints]], [m.bodies], [bodies])

    at_rest = {k: ca.SX.zeros(n) for k in (1, 0, -1)}
    for s in at_rest:
        law = laws.forces(ca.SX.ones(joints) * s)
        at_rest[s] = ca.substitute(law, m.v, ca.SX.zeros(n))
    upper, lower = (at_rest[s][:joints] - at_rest[0][:joints] for s in (1, -1))

    weight = dynamics.inverse_dynamics(m, ca.SX.zeros(n))
    weight = ca.substitute([weight], [m.bodies, m.v], [bodies, ca.SX.zeros(n)])[0]
    force = weight + ca.substitute(at_rest[0], u, ca.SX.zeros(joints))

    return Equations(
        name=robot.name,
        description=robot.description,
        coordinates=robot.coordinates,
        joints=joints,
        parameters=robot.parameters,
        units=robot.units,
        nonnegative=laws.nonnegative,
        sticking=laws.sticking,
        prismatic=tuple(joint.kind == "prismatic" for joint in robot.joints),
        controller=robot.controller,
        descriptions=_descriptions(robot),
        laws=tuple((k, law.title, law.latex) for k, joint in robot.numbered for law in joint.effects),
        rates=ca.Function("rates", [x, u, p, mode], ca.cse([dx, imbalance, resisting[:joints]])),
        breakaway=ca.Function("breakaway", [x, u, p], ca.cse([upper, lower])),
        balance=ca.Function("balance", [x, p], [ca.cse(force)]),
        tip=ca.Function("tip", [x], [ca.cse(dynamics.tip_position(m))]),
        skeleton=ca.Function("skeleton", [x], [dynamics.skeleton(m)]),
    )


def _descriptions(robot: Robot) -> dict[str, str]:
    """What each parameter is, in a sentence."""
    words = {
        "m": "Mass",
        "ms": "First moment of mass about the joint",
        "J": "Moment of inertia about the joint",
    }
    links = {}
    for k in range(1, len(robot.links) + 1):
        for name in LINK_PARAMETERS:
            kind, _, axes = name.rstrip("]").partition("[")
            links[f"link{k}.{name}"] = f"{words[kind]} of link {k}{axes and ', component ' + axes}"
    joints = {
        parameter_name(k, law.name, p.name): f"Joint {k}, {law.title}: {p.name}"
        for k, joint in robot.numbered
        for law in joint.effects
        for p in law.parameters
    }
    return links | joints


class _Laws:
    """Every law of every joint as CasADi expressions on the left of eq. (8)."""

    def __init__(self, robot: Robot, m: dynamics.Mechanism, p: ca.SX, u: ca.SX):
        self.robot, self.m = robot, m
        names, order = robot.coordinates, list(robot.parameters)
        self.signals: list[dict[str, ca.SX]] = []
        self.places: list[dict[str, int]] = []
        for k, joint in robot.numbered:
            at = {"e": names.index(f"joint{k}.e")}
            at |= {f"eps{i}": names.index(f"joint{k}.eps[{i}]") for i in joint.deformations}
            known = {name: m.q[i] for name, i in at.items()}
            known |= {"d" + name: m.v[i] for name, i in at.items()}
            self.signals.append(known | {"tau": u[k - 1]})
            self.places.append(at)
        self.parameters = [
            {
                effect: {name: p[order.index(parameter_name(k, effect, name))] for name in values}
                for effect, values in joint.values.items()
            }
            for k, joint in robot.numbered
        ]
        self.armature = self._armature()
        self.sticking = tuple(any(law.holds_still for law in joint.effects) for joint in robot.joints)
        self.nonnegative = frozenset(
            parameter_name(k, law.name, p.name)
            for k, joint in robot.numbered
            for law in joint.effects
            for p in law.parameters
            if p.lower >= 0
        ) | {f"link{k}.m" for k, _ in enumerate(robot.links, start=1)}

    def forces(self, mode: ca.SX) -> ca.SX:
        """Sum of the laws at each coordinate, without the part that multiplies accelerations."""
        total = ca.SX.zeros(self.m.q.numel())
        for k, joint in enumerate(self.robot.joints):
            for effect in joint.effects:
                for coordinate, law in effect.forces.items():
                    static = law.subs(signals.dde, 0)
                    total[self.places[k][coordinate.name]] += self._value(k, effect, static, mode[k])
        return total

    def _armature(self) -> ca.SX:
        armature = ca.SX.zeros(self.m.q.numel())
        for k, joint in enumerate(self.robot.joints):
            for effect in joint.effects:
                inertia = sympy.diff(effect.forces.get(signals.e, sympy.S.Zero), signals.dde)
                armature[k] += self._value(k, effect, inertia, ca.SX(0))
        return armature

    def _value(self, k: int, effect: Effect, law: sympy.Expr, mode: ca.SX) -> ca.SX:
        law = law.subs({sympy.sign(signals.de): _MODE, sympy.Abs(signals.de): _MODE * signals.de})
        known = self.signals[k] | self.parameters[k][effect.name] | {"mode": mode}
        unknown = [s.name for s in law.free_symbols if s.name not in known]  # pyright: ignore
        if unknown:
            raise ValueError(
                f"effect {effect.name} at joint {k + 1} needs {unknown[0]}, which the joint has not"
            )
        symbols = sorted(law.free_symbols, key=str)
        function = sympy.lambdify(symbols, law, modules=[_TO_CASADI])
        return ca.SX(function(*(known[s.name] for s in symbols)))  # pyright: ignore
