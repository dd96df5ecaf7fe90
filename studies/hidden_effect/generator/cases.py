"""The cases of the blind study: which robots, which hidden laws, which experiments."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.link import LINK_PARAMETERS, Link
from flexmodels.robot import Robot

from .laws import LAWS, Draw, Law, Levels
from .run import Hidden, Noise, Plan, reference_levels, standard
from .stability import LinearLoop

LOGS = ("train1", "train2", "heldout")
DECAY = 0.999  # per controller period, of the slowest oscillation of a true robot


@dataclass(frozen=True)
class Origin:
    """What a case was drawn from: its text, the plain robot, seed and amplitude."""

    spec: str
    robot: Robot
    seed: int
    amplitude: float


@dataclass(frozen=True)
class Case:
    """One robot with its secret. `id` says nothing; everything else is for scoring only.

    kind   null | single | pair | outside | unobservable
    laws   the hidden laws, none for a null
    robot  with its true parameters
    plans  of LOGS
    seed   of the logs' random phases and noise
    """

    id: str
    kind: str
    laws: tuple[Hidden, ...]
    robot: Robot
    plans: tuple[Plan, ...]
    seed: int
    noise: Noise
    origin: Origin


def perturbed(robot: Robot, rng: np.random.Generator, low: float = 0.10, high: float = 0.25) -> Robot:
    """The same geometry; every dynamic parameter off by a random 10-25 %, bodies still physical."""

    def off(size: int | None = None):
        return 1 + rng.choice([-1.0, 1.0], size) * rng.uniform(low, high, size)

    values: dict[str, float] = {}
    for k, link in enumerate(robot.links, start=1):
        com, spread = _spread(link)
        axes, spreads = np.linalg.eigh(spread)[1], np.linalg.eigvalsh(spread)
        m = link.m * float(off())
        spread = axes @ np.diag(spreads * off(3) * m / link.m) @ axes.T
        J_com = np.trace(spread) * np.eye(3) - spread
        body = Link.of_centre(m, com * off(3), J_com)
        values |= {f"link{k}.{name}": body.values[name] for name in LINK_PARAMETERS}
    laws = [name for name in robot.parameters if name.startswith("joint")]
    values |= {name: robot.parameters[name] * float(off()) for name in laws}
    return robot.with_parameters(values)


def _spread(link: Link) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass and second moments of mass about it, which are positive definite for real bodies."""
    com, J = link.about_centre()
    return com, np.trace(J) / 2 * np.eye(3) - J


@dataclass(frozen=True)
class Basis:
    """What every case starts from: the plain robot, the levels that it shows, and its linear loop."""

    robot: Robot
    levels: Levels
    loop: LinearLoop

    @staticmethod
    def of(robot: Robot) -> "Basis":
        return Basis(robot, reference_levels(robot), LinearLoop(robot))


def running(basis: Basis, rng: np.random.Generator) -> Robot:
    """A perturbed robot whose loop decays in every pose; one whose does not could not be measured."""
    plan, n = standard(basis.robot), len(basis.robot.joints)
    poses = np.vstack([np.zeros(n), plan.swing, rng.uniform(-0.3, 0.3 + np.array(plan.swing), (8, n))])
    for _ in range(100):
        robot = perturbed(basis.robot, rng)
        if basis.loop.slowest_decay(robot, poses) < DECAY:
            return robot
    raise RuntimeError(f"robot {basis.robot.name}: no perturbed robot has a stable loop; lower its gains")


def plans(robot: Robot, rng: np.random.Generator) -> tuple[Plan, ...]:
    """Two logs to train on and one of another trajectory, with other periods, swings and tones."""
    train, n = standard(robot), len(robot.joints)
    shares, signs = rng.uniform(0.55, 0.95, n), rng.choice([-1.0, 1.0], n)
    other = replace(
        train,
        swing=tuple(float(s) for s in np.array(train.swing) * shares),
        start=tuple(float(s) for s in signs * rng.uniform(0.05, 0.3, n)),
        period=tuple(float(s) for s in np.array(train.period) * rng.uniform(0.75, 1.6, n)),
        rms=tuple(float(s) for s in np.array(train.rms) * rng.uniform(0.5, 0.9, n)),
        lines=int(rng.integers(120, 300)),
    )
    return train, train, other


def draw(
    name: str, robot: Robot, levels: Levels, rng: np.random.Generator, amplitude: float = 1.0, joint: int = 0
) -> Hidden:
    """A law with random constants, at `joint` or (0) at a random one that it may sit at."""
    allowed = _places(LAWS[name], len(robot.joints))
    if joint > len(robot.joints) or not (joint or allowed):
        raise ValueError(f"law {name} cannot sit at joint {joint or 'any'} of robot {robot.name}")
    k = joint or int(rng.choice(allowed))
    return Hidden(name, k, LAWS[name].draw(Draw(rng, k, levels, amplitude)))


def single(spec: str, basis: Basis, seed: int, amplitude: float = 1.0) -> Case:
    """A case from its seed and a text: `null`, a law, `law@joint`, `law+law`, or a name of UNOBSERVABLE."""
    rng = np.random.default_rng([seed, *spec.encode()])
    robot, kind = basis.robot, None
    true = running(basis, rng)
    levels = replace(basis.levels, values=true.parameters)
    own = plans(robot, rng)
    laws: list[Hidden] = []
    if spec in UNOBSERVABLE:
        kind, law_name, joint, change_law, change_plan = "unobservable", *UNOBSERVABLE[spec]
        hidden = draw(law_name, true, levels, rng, joint=joint)
        laws = [replace(hidden, constants={**hidden.constants, **change_law(hidden, levels)})]
        own = tuple(change_plan(plan, hidden.joint) for plan in own)
    elif spec != "null":
        for part in spec.split("+"):
            name, _, joint = part.partition("@")
            _known(name)
            laws.append(draw(name, true, levels, rng, amplitude, int(joint or 0)))
        if any(h.law == "payload" for h in laws):
            own = (replace(own[0], payload=False), *own[1:])
    kind = kind or _kind(laws)
    secret = hashlib.sha256(f"{seed} {spec} {amplitude}".encode()).hexdigest()
    origin = Origin(spec, basis.robot, seed, amplitude)
    return Case(secret[:8], kind, tuple(laws), true, own, int(secret[8:15], 16), Noise(), origin)


def redrawn(case: Case) -> Case:
    """Another robot and other constants for the same text, under the same id and at the same pace."""
    origin = case.origin
    drawn = single(origin.spec, Basis.of(origin.robot), origin.seed + 1, origin.amplitude)
    pace = [plan.pace for plan in case.plans]
    return replace(drawn, id=case.id, plans=tuple(map(paced, drawn.plans, pace)))


def paced(plan: Plan, pace: float) -> Plan:
    """The plan from point to point at a pace [rad/s]; 0: as it is."""
    return replace(plan, pace=pace)


def case_list(basis: Basis, seed: int, nulls: int = 12, amplitude: float = 1.0) -> list[Case]:
    """The full study, in an order that says nothing.

    Nulls, every law of the catalogue once, five pairs, five laws that no catalogue lists, five laws that the
    data cannot show.
    """
    rng = np.random.default_rng(seed)
    inside = [name for name, law in LAWS.items() if law.catalogue]
    outside = [name for name, law in LAWS.items() if not law.catalogue]
    specs = ["null"] * nulls + inside
    specs += [_pair(rng, inside, len(basis.robot.joints)) for _ in range(5)]
    specs += [str(name) for name in rng.choice(outside, 5, replace=False)]
    specs += [str(name) for name in rng.choice(list(UNOBSERVABLE), 5, replace=False)]
    seeds = rng.integers(2**31, size=len(specs))
    cases = [single(spec, basis, int(s), amplitude) for spec, s in zip(specs, seeds, strict=True)]
    return sorted(cases, key=lambda case: case.id)


def _pair(rng: np.random.Generator, names: Sequence[str], joints: int) -> str:
    """Two different laws; in about a third of the pairs at the same joint where both may sit there."""
    first, second = (LAWS[str(name)] for name in rng.choice(names, 2, replace=False))
    places = [_places(law, joints) for law in (first, second)]
    common = sorted(set(places[0]) & set(places[1]))
    if common and rng.uniform() < 1 / 3:
        k = j = int(rng.choice(common))
    else:
        k = int(rng.choice(places[0]))
        j = int(rng.choice([p for p in places[1] if p != k] or places[1]))
    return f"{first.name}@{k}+{second.name}@{j}"


def _places(law: Law, joints: int) -> tuple[int, ...]:
    return tuple(k for k in law.joints or range(1, joints + 1) if k <= joints)


def _known(name: str) -> None:
    if name not in LAWS:
        raise ValueError(
            f"unknown case {name!r}: give null, a law ({', '.join(LAWS)}), law@joint, law+law, "
            f"or one that data cannot show ({', '.join(UNOBSERVABLE)})"
        )


def _kind(laws: Sequence[Hidden]) -> str:
    if len(laws) > 1:
        return "pair"
    return "null" if not laws else "single" if LAWS[laws[0].law].catalogue else "outside"


def _at(values: tuple[float, ...], k: int, value: float) -> tuple[float, ...]:
    return (*values[: k - 1], value, *values[k:])


def _turning(plan: Plan, k: int) -> Plan:
    """The joint turns on at a rad/s all the time and never slows down much."""
    calm = _at(plan.swing, k, 0.3), _at(plan.rms, k, 0.3 * plan.rms[k - 1])
    return replace(plan, drift=_at(plan.drift, k, 1.0), swing=calm[0], rms=calm[1], lead=4.0)


def _loaded(plan: Plan, k: int) -> Plan:
    """The joint leans to one side and moves gently, as do the others, so that its load keeps its sign."""
    gentle = tuple(0.3 * swing for swing in plan.swing)
    start = tuple(0.6 if i == k else 0.1 for i in range(1, len(gentle) + 1))
    return replace(plan, start=start, swing=gentle, rms=tuple(0.2 * rms for rms in plan.rms))


def _as_it_is(plan: Plan, _: int) -> Plan:
    return plan


# name -> law, joint (0: any), constants that hide it, and the experiment that hides it
UNOBSERVABLE = {
    "payload_in_every_log": ("payload", 0, lambda h, lv: {}, _as_it_is),
    "stribeck_never_slow": ("stribeck", 1, lambda h, lv: {"speed": 0.01}, _turning),
    "saturation_above_every_torque": (
        "torque_saturation",
        0,
        lambda h, lv: {"limit": 2.5 * float(lv.peak[h.joint - 1]), "soft": 0.0},
        _as_it_is,
    ),
    "backlash_on_one_flank": (
        "backlash",
        2,
        lambda h, lv: {"half": 0.12 * float(lv.twist[1]), "round": 0.05},
        _loaded,
    ),
    "hardening_below_noise": (
        "hardening_stiffness",
        0,
        lambda h, lv: {"stiffer": 1e-4 * h.constants["stiffer"]},
        _as_it_is,
    ),
    "viscous_drift_too_slow": ("viscous_drift", 0, lambda h, lv: {"warm_up": 1e5}, _as_it_is),
}
