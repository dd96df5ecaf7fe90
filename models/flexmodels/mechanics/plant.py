"""Robot + laws + controller -> Equations, the one description from which an FMU is generated.

State x = (q, v, z) with the laws' own states z. Dry friction is written with a mode per motor hinge: +1
slides forward, -1 backward, 0 is stuck. A mode takes the place of sign(de); a stuck hinge is held at
constant speed (zero) and its friction is the reaction, found exactly for any number of stuck hinges at once.
"""

from dataclasses import dataclass

import casadi as ca

from flexmodels.joint import parameter_name
from flexmodels.link import LINK_PARAMETERS
from flexmodels.mechanics import articulated, dynamics, projected
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
    breakaway(x, u, p) -> upper, lower        dry friction at zero speed, either direction
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
    x, rest = ca.vertcat(m.q, m.v, laws.z), ca.SX.zeros(n)

    free = ca.SX.ones(n)
    for k in range(joints):
        free[k] = ca.fabs(mode[k]) if laws.sticking[k] else 1
    resisting = laws.forces(mode)
    applied = ca.vertcat(u, ca.SX.zeros(n - joints)) - resisting
    if robot.passive or laws.coupled:
        a, imbalance = projected.forward_dynamics(m, applied, laws.armature, free)
        pivots = projected.pivots(m, laws.armature)
    else:
        a, imbalance = articulated.forward_dynamics(m, applied, ca.diag(laws.armature), free)
        pivots = articulated.pivots(m, ca.diag(laws.armature))
    a, imbalance, pivots = ca.substitute([a, imbalance[:joints], pivots], [m.bodies], [bodies])
    dx, dx_in = ca.vertcat(m.v, a, laws.rates(mode)), ca.SX.sym("dx", x.numel())

    at_rest = {s: ca.substitute(laws.forces(ca.SX.ones(joints) * s), m.v, rest) for s in (1, 0, -1)}
    upper, lower = (at_rest[s][:joints] - at_rest[0][:joints] for s in (1, -1))

    weight = dynamics.inverse_dynamics(m, rest)
    weight = ca.substitute([weight], [m.bodies, m.v], [bodies, rest])[0]
    start = laws.start()
    force = ca.substitute(weight + ca.substitute(at_rest[0], laws.z, start), u, ca.SX.zeros(joints))

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
        rates=ca.Function("rates", [x, u, p, mode], ca.cse([dx, imbalance, resisting[:joints]])),
        breakaway=ca.Function("breakaway", [x, u, p], ca.cse([upper, lower])),
        laws=ca.Function(
            "laws", [x, u, p, mode, dx_in], [ca.cse(resisting + laws.armature @ dx_in[n : 2 * n])]
        ),
        start=ca.Function("start", [x, u, p], [ca.cse(start)]),
        pivots=ca.Function("pivots", [x, p], [ca.cse(pivots)]),
        balance=ca.Function("balance", [x, p], [ca.cse(force)]),
        tip=ca.Function("tip", [x], [ca.cse(dynamics.tip_position(m))]),
        shown=ca.Function("shown", [x], [ca.cse(ca.vertcat(*dynamics.tip_motion(m), *_links(robot, m)))]),
        skeleton=ca.Function("skeleton", [x], [dynamics.skeleton(m)]),
    )


def _links(robot: Robot, m: dynamics.Mechanism) -> tuple[dynamics.SX, dynamics.SX]:
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
