"""Equations of motion of a serial arm with flexible hinges, written apart from the project's own plant.

Kane's way, in axes that are parallel to the base in the zero pose: per link the partial angular velocities
W of its coordinates, Newton's and Euler's equations outwards and inwards for the bias forces, and a
composite-body recursion for the mass matrix. Dry friction is smooth: tanh(v / SMOOTH). Only the numbers of a
robot (geometry, parameters, gains) are taken from the project.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from flexmodels.coordinate import deformation_of, of_joint
from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot

SX = Any  # casadi.SX; its stubs do not describe operators
SMOOTH = 1e-3  # rad/s
BASE_MASS = 120.0  # kg, of a base that tilts
BASE_INERTIA = (14.0, 14.0, 10.0)  # kg m2, about the point about which it tilts


@dataclass(frozen=True)
class Element:
    """One link behind its hinges: rotation R to the axes before, angular velocity W v, its rate, place."""

    at: list[int]
    R: SX
    W: SX
    bias: SX
    origin: np.ndarray


class Arm:
    """Symbols of the arm, to which laws add forces, inertias, states and body parameters.

    q, v      coordinates (every e, then every eps, then two tilts of the base if it tilts) and their rates
    u, t      acting motor torques [N m] and time [s]
    numbers   value of every parameter by its name; `number` makes one
    bodies    per link m, ms, J about its joint, as expressions
    """

    def __init__(self, robot: Robot, tilting: bool = False):
        kinds = {joint.kind for joint in robot.joints}
        if kinds != {"revolute"} or robot.passive or any(j.parent is not None for j in robot.joints):
            raise ValueError(f"robot {robot.name}: only a serial arm of driven hinges can be generated")
        self.robot, self.tilting, self.joints = robot, tilting, len(robot.joints)
        self.names = [*robot.coordinates, *(["base.tilt[1]", "base.tilt[2]"] if tilting else [])]
        n = len(self.names)
        self.q, self.v = ca.SX.sym("q", n), ca.SX.sym("v", n)
        self.u, self.t = ca.SX.sym("u", self.joints), ca.SX.sym("t")
        self.numbers: dict[str, float] = {}
        self._symbols: list[SX] = []
        values = robot.parameters
        self.own = {name: self.number(name, value) for name, value in values.items()}
        self.bodies = [
            [self.own[f"link{k}.{name}"] for name in LINK_PARAMETERS] for k in range(1, self.joints + 1)
        ]
        self.base, self.hidden = ca.SX.zeros(n), ca.SX.zeros(n)
        self.added, self.states = ca.SX.zeros(n, n), []
        self.rates: list[SX] = []
        self._base_laws()

    def number(self, name: str, value: float) -> SX:
        """A parameter that is set when the arm runs, so that its value needs no new compilation."""
        self.numbers[name] = float(value)
        self._symbols.append(ca.SX.sym(name))
        return self._symbols[-1]

    @property
    def p(self) -> SX:
        return ca.vertcat(*self._symbols)

    def at(self, name: str) -> int:
        return self.names.index(name)

    def e(self, k: int) -> SX:
        return self.q[k - 1]

    def de(self, k: int) -> SX:
        return self.v[k - 1]

    def eps(self, k: int, i: int) -> SX:
        return self.q[self.at(deformation_of(k, i))]

    def deps(self, k: int, i: int) -> SX:
        return self.v[self.at(deformation_of(k, i))]

    def load(self, k: int) -> SX:
        """Torque in the transmission of joint k."""
        stiff, damp = self.own[of_joint(k, "k[1]")], self.own[of_joint(k, "d[1]")]
        return stiff * self.eps(k, 1) + damp * self.deps(k, 1)

    def resist(self, coordinate: str, force: SX) -> None:
        """A hidden force on the left of M a + h + laws = torque."""
        self.hidden[self.at(coordinate)] += force

    def potential(self, energy: SX) -> None:
        """Hidden forces of an energy of q."""
        self.hidden += ca.gradient(energy, self.q)

    def state(self, name: str, rate: Callable[[SX], SX]) -> SX:
        """A state of a law, 0 at the start; `rate` gives its rate from it."""
        z = ca.SX.sym(name)
        self.states.append(z)
        self.rates.append(rate(z))
        return z

    def inertia(self, vector: Mapping[str, float], value: SX) -> None:
        """value (sum of vector[i] v_i)^2 / 2 more of kinetic energy."""
        row = ca.SX.zeros(len(self.names))
        for name, factor in vector.items():
            row[self.at(name)] = factor
        self.added += value * row @ row.T

    def _base_laws(self) -> None:
        for k, joint in self.robot.numbered:
            own = {name.split(".", 1)[1]: s for name, s in self.own.items() if name.startswith(f"joint{k}.")}
            rest = set(own) - {"J_m", "coulomb", "viscous", "offset"}
            rest -= {f"{law}[{i}]" for law in "kd" for i in joint.deformations}
            if rest:
                raise ValueError(f"robot {self.robot.name}, joint {k}: {min(rest)} has no law here")
            v, zero = self.de(k), ca.SX(0)
            dry = own.get("coulomb", zero) * ca.tanh(v / SMOOTH)
            self.base[k - 1] += dry + own.get("viscous", zero) * v + own.get("offset", zero)
            self.added[k - 1, k - 1] += own.get("J_m", zero)
            for i in joint.deformations:
                force = own[f"k[{i}]"] * self.eps(k, i) + own[f"d[{i}]"] * self.deps(k, i)
                self.base[self.at(deformation_of(k, i))] += force

    def elements(self) -> tuple[list[Element], list[list[SX]]]:
        """Links and their bodies, a tilting base first."""
        elements, bodies = [], list(self.bodies)
        if self.tilting:
            at = [self.at(f"base.tilt[{i}]") for i in (1, 2)]
            up = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]).T  # x' is up
            elements.append(self._element(up, np.zeros(3), None, None, at, at))
            xx, yy, zz = BASE_INERTIA
            bodies.insert(0, [ca.SX(x) for x in (BASE_MASS, 0, 0, 0, xx, 0, 0, yy, 0, zz)])
        for k, joint in self.robot.numbered:
            eps = {i: self.at(deformation_of(k, i)) for i in joint.deformations}
            bends = [eps[i] for i in (2, 3) if i in eps]
            at = [k - 1, *eps.values()]
            elements.append(self._element(joint.triad, np.array(joint.origin), k - 1, eps.get(1), bends, at))
        return elements, bodies

    def _element(self, triad, origin, motor, twist, bends, at) -> Element:
        """Turn about x' by e, the shortest that lays x' on (c, eps2, eps3), about the new x' by eps1."""
        T, x = ca.sparsify(ca.DM(np.round(triad, 15))), ca.SX([1.0, 0, 0])
        outer = _about_x(0 if motor is None else self.q[motor])
        inner = _about_x(0 if twist is None else self.q[twist])
        y, z = (self.q[bends[0]], self.q[bends[1]]) if bends else (ca.SX(0), ca.SX(0))
        K = ca.skew(ca.vertcat(0, -z, y))
        B = ca.SX.eye(3) + K + K @ K / (1 + ca.sqrt(1 - y**2 - z**2))
        columns = {}
        if motor is not None:
            columns[motor] = inner.T @ B.T @ x
        if twist is not None:
            columns[twist] = x
        for i in bends:
            turn = B.T @ ca.reshape(ca.jacobian(ca.vec(B), self.q[i]), 3, 3)
            columns[i] = inner.T @ ca.inv_skew(turn)
        W = T @ ca.horzcat(*(columns[i] for i in at))
        bias = ca.jtimes(W @ self.v[at], self.q, self.v)
        return Element(at, T @ outer @ B @ inner @ T.T, W, bias, origin)


def _about_x(angle: SX) -> SX:
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.blockcat([[ca.SX(1), 0, 0], [0, c, -s], [0, s, c]])


def mass_matrix(arm: Arm) -> SX:
    """M(q) with motor inertias: composite bodies from the tip inwards."""
    elements, bodies = arm.elements()
    M = ca.SX.zeros(len(arm.names), len(arm.names))
    m, ms, J = (ca.SX(0), ca.SX.zeros(3), ca.SX.zeros(3, 3))
    for j in reversed(range(len(elements))):
        own = _body(bodies[j])
        m, ms, J = m + own[0], ms + own[1], J + own[2]
        element = elements[j]
        f, n = -ca.skew(ms) @ element.W, J @ element.W
        M[element.at, element.at] = element.W.T @ n
        for i in reversed(range(j)):
            R, r = elements[i + 1].R, ca.skew(ca.DM(elements[i + 1].origin))
            f = R @ f
            n = R @ n + r @ f
            M[elements[i].at, element.at] = elements[i].W.T @ n
            M[element.at, elements[i].at] = M[elements[i].at, element.at].T
        ms_out = element.R @ ms
        r = element.origin
        S, s = ca.skew(ca.DM(r)), ca.skew(ms_out)
        J = element.R @ J @ element.R.T - S @ s - s @ S - m * S @ S
        ms = ms_out + m * r
    return M + arm.added


def bias_forces(arm: Arm) -> SX:
    """h(q, v): what accelerations, all zero, would need of generalised forces; gravity included."""
    elements, bodies = arm.elements()
    w, dw, a = ca.SX.zeros(3), ca.SX.zeros(3), -ca.SX(ca.DM(arm.robot.gravity))
    wrenches = []
    for element, body in zip(elements, bodies, strict=True):
        r, back = ca.DM(element.origin), element.R.T
        a = back @ (a + ca.cross(dw, r) + ca.cross(w, ca.cross(w, r)))
        carried, own = back @ w, element.W @ arm.v[element.at]
        dw = back @ dw + ca.cross(carried, own) + element.bias
        w = carried + own
        m, ms, J = _body(body)
        f = m * a + ca.cross(dw, ms) + ca.cross(w, ca.cross(w, ms))
        wrenches.append((f, J @ dw + ca.cross(w, J @ w) + ca.cross(ms, a)))
    h = ca.SX.zeros(len(arm.names))
    f, n = ca.SX.zeros(3), ca.SX.zeros(3)
    for element, (own_f, own_n) in zip(reversed(elements), reversed(wrenches), strict=True):
        f, n = f + own_f, n + own_n
        h[element.at] = element.W.T @ n
        f = element.R @ f
        n = element.R @ n + ca.cross(ca.DM(element.origin), f)
    return h


def tip(arm: Arm) -> SX:
    """Position of the tip in axes of the ground [m]."""
    place = ca.SX(ca.DM(arm.robot.tip))
    for element in reversed(arm.elements()[0]):
        place = element.origin + element.R @ place
    return place


def force(arm: Arm) -> SX:
    """Everything but M a: motor torques less laws and bias forces."""
    applied = ca.vertcat(arm.u, ca.SX.zeros(len(arm.names) - arm.joints))
    return applied - arm.base - arm.hidden - bias_forces(arm)


def rates(arm: Arm) -> SX:
    """Rate of the state (q, v, states of the laws)."""
    D, LT, order = ca.ldl(mass_matrix(arm), True)
    a = ca.ldl_solve(force(arm), D, LT, order)
    return ca.vertcat(arm.v, a, *arm.rates)


def _body(body: list[SX]) -> tuple[SX, SX, SX]:
    m, x, y, z, xx, xy, xz, yy, yz, zz = body
    return m, ca.vertcat(x, y, z), ca.blockcat([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
