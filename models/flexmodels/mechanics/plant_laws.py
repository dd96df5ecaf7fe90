"""Every law of every joint as CasADi expressions on the left of eq. (8).

A friction mode takes the place of sign(de), and mode * de that of |de|; see flexmodels.mechanics.plant.
"""

from dataclasses import dataclass
from functools import reduce
from typing import Any

import casadi as ca
import sympy

from flexmodels.coordinate import Coordinate, of_joint
from flexmodels.effects import signals
from flexmodels.effects.effect import Effect, State
from flexmodels.joint import parameter_name, unit_at
from flexmodels.link import LINK_PARAMETERS
from flexmodels.mechanics import dynamics
from flexmodels.robot import Robot

SX = Any  # casadi.SX; its stubs do not describe operators

_MODE = sympy.Symbol("mode", real=True)
_SIGNUM = sympy.Function("signum")
_TO_CASADI = {
    "Abs": ca.fabs,
    "signum": ca.sign,
    "exp": ca.exp,
    "sqrt": ca.sqrt,
    "tanh": ca.tanh,
    "sin": ca.sin,
    "cos": ca.cos,
    "Min": lambda *values: reduce(ca.fmin, values),
    "Max": lambda *values: reduce(ca.fmax, values),
}


@dataclass(frozen=True)
class Memory:
    """A state of a law as a continuous state of the plant."""

    name: str
    unit: str
    description: str


class PlantLaws:
    """The laws of a robot in the symbols of its mechanism.

    z           their states, and the time if a law reads it;  memories   what these are
    loads       (joints,), what links ask of the motors that turn them directly
    armature    (n, n), the laws' inertia
    bodies      10 x links, what they add to the links
    """

    def __init__(self, robot: Robot, m: dynamics.Mechanism, p: SX, u: SX):
        self.robot, self.m, self.joints = robot, m, len(robot.joints)
        self.acting = [(k - 1, effect) for k, joint in robot.numbered for effect in joint.effects]
        self.parameters = dict(zip(robot.parameters, ca.vertsplit(p), strict=True))
        self.memories = tuple(self._memories())
        self.z = ca.SX.sym("z", len(self.memories))
        self.loads = ca.SX.sym("load", self.joints)
        self.places = [self._places(k) for k in range(self.joints)]
        self.signals = [self._signals(k, u) for k in range(self.joints)]
        self.armature, self.bodies = self._armature(), self._bodies()

    @property
    def coupled(self) -> bool:
        """Whether an acceleration takes force at another coordinate."""
        return self.armature.sparsity().nnz() > ca.diag(ca.diag(self.armature)).sparsity().nnz()

    @property
    def loaded(self) -> list[int]:
        """Places of the rigid joints at which a law reads what the links ask of the motor."""
        reading = {k for k, effect in self.acting if signals.load in effect.symbols}
        return sorted(k for k in reading if not self.robot.joints[k].flexible)

    @property
    def sticking(self) -> tuple[bool, ...]:
        """Per joint whether a law has friction modes."""
        return tuple(any(law.has_modes for law in joint.effects) for joint in self.robot.joints)

    @property
    def nonnegative(self) -> frozenset[str]:
        names = (
            parameter_name(k + 1, law.name, p.name)
            for k, law in self.acting
            for p in law.parameters
            if p.lower >= 0
        )
        return frozenset(names) | {f"link{k}.m" for k, _ in enumerate(self.robot.links, start=1)}

    def forces(self, mode: SX) -> SX:
        """Sum of the laws at each coordinate, without the part that multiplies accelerations."""
        total = ca.SX.zeros(self.m.q.numel())
        for k, effect in self.acting:
            for coordinate, law in effect.laws.items():
                still = law.subs({signals.dde: 0, signals.beyond.dde: 0})
                total[self.places[k][coordinate.name]] += self._value(k, effect, still, mode[k])
        return total

    def rates(self, mode: SX) -> SX:
        """Rates of z."""
        rates = [self._value(k, effect, s.rate, mode[k]) for k, effect, s in self._states()]
        return ca.vertcat(*rates, *([1] if self._has_clock else []))

    def start(self) -> SX:
        """z at rest: the states' start values, or where their rates are zero."""
        starts = [self._start(k, effect, state) for k, effect, state in self._states()]
        at_rest = ca.vertcat(*starts, *([0] if self._has_clock else []))
        return ca.substitute(ca.SX(at_rest), self.m.v, ca.SX.zeros(self.m.v.numel()))

    @property
    def _has_clock(self) -> bool:
        return any(signals.time in effect.symbols for _, effect in self.acting)

    def _states(self) -> list[tuple[int, Effect, State]]:
        return [(k, effect, state) for k, effect in self.acting for state in effect.states]

    def _memories(self):
        for k, effect, state in self._states():
            name = of_joint(k + 1, f"{effect.name}.{state.name}")
            unit = unit_at(self.robot.joints[k], state.unit)
            yield Memory(name, unit, f"Joint {k + 1}, {effect.title}: {state.name}")
        if self._has_clock:
            yield Memory("clock", "s", "Time since the start, for the laws that change with it")

    def _start(self, k: int, effect: Effect, state: State) -> SX:
        if state.start is not None:
            return ca.SX(state.start)
        a, b = (self._value(k, effect, law, ca.SX(0)) for law in state.coefficients)
        return ca.if_else(a == 0, 0, -b / a)

    def _places(self, k: int) -> dict[str, int]:
        """Coordinates of the joint, and the next one's motor hinge, by their signals' names."""
        at = {c.symbol: i for i, c in enumerate(self.robot.q) if c.joint == k + 1}
        return at | ({"beyond.e": self.robot.q.index(Coordinate(k + 2, "e"))} if k + 1 < self.joints else {})

    def _signals(self, k: int, u: SX) -> dict[str, SX]:
        known = {name: self.m.q[i] for name, i in self.places[k].items()}
        known |= {_rate_name(name): self.m.v[i] for name, i in self.places[k].items()}
        if self.robot.joints[k].flexible:
            known["load"] = self.parameters[parameter_name(k + 1, "stiffness", "k[1]")] * known["eps1"]
        else:
            known["load"] = self.loads[k]
        return known | {"tau": u[k]} | ({"time": self.z[-1]} if self._has_clock else {})

    def _armature(self) -> SX:
        n = self.m.q.numel()
        armature = ca.SX(n, n)
        for k, effect in self.acting:
            for coordinate, law in effect.laws.items():
                row = self.places[k][coordinate.name]
                for a, moved in ((signals.dde, "e"), (signals.beyond.dde, "beyond.e")):
                    inertia = sympy.diff(law, a)
                    if inertia != 0:
                        armature[row, self.places[k][moved]] += self._value(k, effect, inertia, ca.SX(0))
        return armature

    def _bodies(self) -> SX:
        bodies = ca.SX.zeros(len(LINK_PARAMETERS), len(self.robot.links))
        at_tip: dict[Any, Any] = dict(zip(signals.tip, self.robot.tip, strict=True))
        for k, effect in self.acting:
            for i, name in enumerate(LINK_PARAMETERS):
                if name in effect.body:
                    law = effect.body[name].subs(at_tip)
                    bodies[i, self.robot.last_link - 1] += self._value(k, effect, law, ca.SX(0))
        return bodies

    def _value(self, k: int, effect: Effect, law: Any, mode: SX) -> SX:
        law = law.subs({sympy.sign(signals.de): _MODE, sympy.Abs(signals.de): _MODE * signals.de})
        law = law.replace(sympy.sign, _SIGNUM)  # Python's printer would write it as a branch
        known = self.signals[k] | self._own(k, effect) | {"mode": mode}
        unknown = [s.name for s in law.free_symbols if s.name not in known]
        if unknown:
            raise ValueError(
                f"effect {effect.name} at joint {k + 1} needs {unknown[0]}, which the joint has not"
            )
        symbols = sorted(law.free_symbols, key=str)
        function = sympy.lambdify(symbols, law, modules=[_TO_CASADI])
        return ca.SX(function(*(known[s.name] for s in symbols)))

    def _own(self, k: int, effect: Effect) -> dict[str, SX]:
        """The law's parameters and states by their own names."""
        names = [memory.name for memory in self.memories]
        parameters = {
            p.name: self.parameters[parameter_name(k + 1, effect.name, p.name)] for p in effect.parameters
        }
        states = {
            s.name: self.z[names.index(of_joint(k + 1, f"{effect.name}.{s.name}"))] for s in effect.states
        }
        return parameters | states


def _rate_name(signal: str) -> str:
    return "beyond.de" if signal == "beyond.e" else "d" + signal
