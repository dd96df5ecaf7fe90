"""Robot + laws + controller -> Equations, the one description from which an FMU is generated.

State x = (q, v, z) with the laws' own states z. Dry friction is written with a mode per motor hinge: +1
slides forward, -1 backward, 0 is stuck. A mode takes the place of sign(de); a stuck hinge is held at
constant speed (zero) and its friction is the reaction, found exactly for any number of stuck hinges at once.
"""

from dataclasses import dataclass
from functools import partial

import casadi as ca

from flexmodels.joint import parameter_name
from flexmodels.link import LINK_PARAMETERS
from flexmodels.mechanics import articulated, dynamics, loads, projected
from flexmodels.mechanics.dynamics import SX
from flexmodels.mechanics.payload import PAYLOAD, carried
from flexmodels.mechanics.plant_laws import Memory, PlantLaws
from flexmodels.robot import Robot
from flexmodels.settings.controller import Controller
from flexmodels.settings.servo import Servo


@dataclass(frozen=True)
class Equations:
    """A plant ready for code generation. All functions are casadi.Function of vectors, SI units.

    rates(x, u, p, mode) -> dx, imbalance, friction
                     imbalance: torque a brake must take at a stuck hinge; friction: sum of the laws at e
    breakaway(x, u, p, mode) -> upper, lower  dry friction at zero speed, either direction
    laws(x, u, p, mode, dx) -> force          what the laws take at each coordinate, inertia included
    balance(x, p) -> force                    generalised forces at rest that the motors must supply
    start(x, u, p) -> z                       the laws' states at rest
    pivots(x, p) -> d                         n, all positive where the mass matrix is positive definite
    tip(x) -> position                        [m]
    shown(x) -> tip velocity, orientation (x, y, z, w), angular velocity; links' positions and velocities
    skeleton(x) -> lines                      3 x 2 lines, from hinge to hinge and to the tip [m]
    Without a controller the torques u are inputs, or (drives) what drives hold of a law that they receive.
    """

    name: str
    description: str
    coordinates: tuple[str, ...]
    memories: tuple[Memory, ...]
    joints: int
    parameters: dict[str, float]
    units: dict[str, str]
    nonnegative: frozenset[str]
    sticking: tuple[bool, ...]
    prismatic: tuple[bool, ...]
    controller: Controller | None
    servo: Servo | None
    descriptions: dict[str, str]
    listed: tuple[tuple[int, str, str], ...]
    rates: ca.Function
    breakaway: ca.Function
    laws: ca.Function
    balance: ca.Function
    start: ca.Function
    pivots: ca.Function
    tip: ca.Function
    shown: ca.Function
    skeleton: ca.Function
    drives: bool = False


def equations(robot: Robot) -> Equations:
    """The robot's equations of motion, eq. (8), with its laws and, where it has one, its controller."""
    m = dynamics.mechanism(robot)
    n, joints = m.q.numel(), len(robot.joints)
    p = ca.SX.sym("p", len(robot.parameters) + len(PAYLOAD))
    u, mode = ca.SX.sym("u", joints), ca.SX.sym("mode", joints)
    laws = PlantLaws(robot, m, p[: -len(PAYLOAD)], u)
    bodies = ca.reshape(p[: m.bodies.numel()], *m.bodies.shape) + laws.bodies
    bodies[:, robot.last_link - 1] += carried(p[-len(PAYLOAD) :], m.tip)
    x = ca.vertcat(m.q, m.v, laws.z)
    dx_in = ca.SX.sym("dx", x.numel())
    results = [
        *_in_motion(robot, m, laws, u, mode),
        _taken(m, laws, mode, dx_in[n : 2 * n]),
        *_at_rest(m, laws, u),
    ]
    dx, imbalance, friction, upper, lower, pivots, taken, force, start = ca.substitute(
        results, [m.bodies], [bodies]
    )
    return Equations(
        name=robot.name,
        description=robot.description,
        coordinates=robot.coordinates,
        memories=laws.memories,
        joints=joints,
        parameters=robot.parameters | dict.fromkeys(PAYLOAD, 0.0),
        units=robot.units | {name: unit for name, (unit, _) in PAYLOAD.items()},
        nonnegative=laws.nonnegative | {"payload.m"},
        sticking=laws.sticking,
        prismatic=tuple(joint.kind == "prismatic" for joint in robot.joints),
        controller=robot.controller,
        servo=robot.servo,
        descriptions=_descriptions(robot),
        listed=tuple((k, law.title, law.latex) for k, joint in robot.numbered for law in joint.effects),
        rates=ca.Function("rates", [x, u, p, mode], ca.cse([dx, imbalance, friction])),
        breakaway=ca.Function("breakaway", [x, u, p, mode], ca.cse([upper, lower])),
        laws=ca.Function("laws", [x, u, p, mode, dx_in], [ca.cse(taken)]),
        start=ca.Function("start", [x, u, p], [ca.cse(start)]),
        pivots=ca.Function("pivots", [x, p], [ca.cse(pivots)]),
        balance=ca.Function("balance", [x, p], [ca.cse(force)]),
        tip=ca.Function("tip", [x], [ca.cse(dynamics.tip_position(m))]),
        shown=ca.Function("shown", [x], [ca.cse(ca.vertcat(*dynamics.tip_motion(m), *_links(robot, m)))]),
        skeleton=ca.Function("skeleton", [x], [dynamics.skeleton(m)]),
    )


def _in_motion(robot: Robot, m: dynamics.Mechanism, laws: PlantLaws, u: SX, mode: SX) -> list[SX]:
    """Rates, imbalance, friction at the motors, dry friction at zero speed either way, pivots."""
    n, joints = m.q.numel(), len(robot.joints)
    free = ca.SX.ones(n)
    for k in range(joints):
        free[k] = ca.fabs(mode[k]) if laws.sticking[k] else 1
    if robot.passive or laws.coupled:
        armature, pivots = laws.armature, projected.pivots(m, laws.armature)
        forward = partial(projected.forward_dynamics, m, armature=armature, free=free)
    else:
        diagonal = ca.diag(laws.armature)
        armature, pivots = ca.diag(diagonal), articulated.pivots(m, diagonal)
        forward = partial(articulated.forward_dynamics, m, armature=diagonal, free=free)
    resisting = laws.forces(mode)
    applied = ca.vertcat(u, ca.SX.zeros(n - joints)) - resisting
    a, imbalance = forward(applied)
    still, forth, back = (_standing(m, laws, sign)[:joints] for sign in (0, 1, -1))
    dx = ca.vertcat(m.v, a, laws.rates(mode))
    found = [dx, imbalance[:joints], resisting[:joints], forth - still, back - still]
    if laws.loaded:
        load = laws.loads[laws.loaded]
        carried = loads.settled(load, laws.loaded, applied, free, armature, forward)
        found = ca.substitute(found, [load], [carried])
    return [*found, pivots]


def _standing(m: dynamics.Mechanism, laws: PlantLaws, sign: int) -> SX:
    """The laws' forces without speed, friction in one direction (1, -1) or neither (0)."""
    return ca.substitute(laws.forces(ca.SX.ones(laws.joints) * sign), m.v, ca.SX.zeros(m.v.numel()))


def _taken(m: dynamics.Mechanism, laws: PlantLaws, mode: SX, a: SX) -> SX:
    """What the laws take at each coordinate under accelerations, inertia included."""
    taken = laws.forces(mode) + laws.armature @ a
    return ca.substitute(taken, laws.loads, dynamics.inverse_dynamics(m, a)[: laws.joints])


def _at_rest(m: dynamics.Mechanism, laws: PlantLaws, u: SX) -> list[SX]:
    """The forces that the motors must supply, and the laws' states."""
    rest, start = ca.SX.zeros(m.q.numel()), laws.start()
    weight = ca.substitute(dynamics.inverse_dynamics(m, rest), m.v, rest)
    force = weight + ca.substitute(_standing(m, laws, 0), laws.z, start)
    force = ca.substitute(force, u, ca.SX.zeros(laws.joints))
    return ca.substitute([force, start], [laws.loads], [weight[: laws.joints]])


def _links(robot: Robot, m: dynamics.Mechanism) -> tuple[SX, SX]:
    """Positions and velocities behind the flexible hinges: the motor's and the twist together."""
    names = robot.coordinates
    along = ca.DM(len(robot.joints), len(names))
    for k, _ in robot.numbered:
        for name in (f"joint{k}.e", f"joint{k}.eps[1]"):
            if name in names:
                along[k - 1, names.index(name)] = 1
    return along @ m.q, along @ m.v


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
    return links | joints | {name: text for name, (_, text) in PAYLOAD.items()}
