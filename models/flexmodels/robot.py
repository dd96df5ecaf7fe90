"""What a robot is: geometry, lumped bodies, laws at its joints and its controller.

All vectors in base axes at e = 0 ("zero pose"). A link's frame lies at its joint and is parallel to the
base axes in the zero pose; its mass moments and inertia are about that point (the paper's eq. (1)).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from flexmodels.effects import BASE, CATALOGUE, load_effects
from flexmodels.effects.effect import Effect
from flexmodels.effects.restriction import objection, restricted
from flexmodels.gearing import Transmission
from flexmodels.linkage import Closure, PassiveJoint
from flexmodels.servo import Servo

LINK_PARAMETERS: dict[str, str] = {
    "m": "kg",
    **{f"ms[{a}]": "kg.m" for a in "xyz"},
    **{f"J[{ab}]": "kg.m2" for ab in ("xx", "xy", "xz", "yy", "yz", "zz")},
}


class RobotError(ValueError):
    """A robot description that cannot be used; the message names the key and the cure."""


@dataclass(frozen=True)
class Link:
    """A rigid body lumped at its joint, eq. (1): mass [kg], first moments [kg m], inertia [kg m2]."""

    m: float
    ms: tuple[float, ...]
    J: tuple[float, ...]  # xx, xy, xz, yy, yz, zz about the joint

    @property
    def values(self) -> dict[str, float]:
        return dict(zip(LINK_PARAMETERS, (self.m, *self.ms, *self.J), strict=True))

    @staticmethod
    def of_values(values: Mapping[str, float]) -> "Link":
        p = [float(values[name]) for name in LINK_PARAMETERS]
        return Link(p[0], tuple(p[1:4]), tuple(p[4:]))

    @staticmethod
    def of_centre(m: float, com: np.ndarray, J_com: np.ndarray) -> "Link":
        """From the centre of mass [m] and the 3 x 3 inertia about it [kg m2] (parallel axes)."""
        J = J_com + m * (com @ com * np.eye(3) - np.outer(com, com))
        return Link(
            float(m), tuple(float(v) for v in m * com), tuple(float(v) for v in J[np.triu_indices(3)])
        )


@dataclass(frozen=True)
class Limits:
    """What a joint may do: position (lower, upper) [rad or m], speed [rad/s or m/s], effort [N m or N]."""

    position: tuple[float, ...] | None = None
    speed: float | None = None
    effort: float | None = None


@dataclass(frozen=True)
class Joint:
    """A motor hinge (or slider), with or without a flexible hinge behind it.

    x, y      hinge triad in the zero pose (z = x cross y); motion is about (or along) x
    origin    from the joint of the parent link [m]
    values    effect name -> parameter name -> value, for every law that acts at this joint
    bends     whether the flexible hinge bends too; else it only twists (eps[1])
    parent    number of the link that it sits on, 0 for the base; None takes the link before
    name      what others call it (in a URDF or a ROS message); may be empty
    limits    None where nothing is known of them
    """

    kind: Literal["revolute", "prismatic"]
    x: tuple[float, ...]
    y: tuple[float, ...]
    origin: tuple[float, ...]
    flexible: bool
    values: Mapping[str, Mapping[str, float]]
    bends: bool = True
    parent: int | None = None
    name: str = ""
    limits: Limits | None = None

    @property
    def triad(self) -> np.ndarray:
        """3 x 3, columns x', y', z' in base axes."""
        x, y = np.array(self.x), np.array(self.y)
        return np.column_stack([x, y, np.cross(x, y)])

    @property
    def deformations(self) -> tuple[int, ...]:
        """Which of eps[1], eps[2], eps[3] the joint has."""
        return (1, 2, 3) if self.flexible and self.bends else (1,) if self.flexible else ()

    def law(self, effect: str) -> Effect:
        """A law of the catalogue as it acts here: on the coordinates that the joint has."""
        return restricted(CATALOGUE[effect], self.deformations)

    @property
    def effects(self) -> tuple[Effect, ...]:
        return tuple(self.law(name) for name in self.values)


@dataclass(frozen=True)
class Controller:
    """Digital PID with held torque, sampled at `rate` [Hz]; gains per joint, SI."""

    rate: float
    Kp: tuple[float, ...]
    Kd: tuple[float, ...]
    Ki: tuple[float, ...]

    @property
    def period(self) -> float:
        return 1.0 / self.rate


@dataclass(frozen=True)
class Column:
    """Where a signal of the log comes from in a foreign file: its name there and a gain to SI."""

    source: str
    gain: float = 1.0


@dataclass(frozen=True)
class Processing:
    """How logged signals are prepared.

    derivative   "central" or "hat"; None takes hat means for a held torque and central differences else
    cutoff       [Hz] of a zero-phase Butterworth of `order`, None for no filter
    decimate     factor by which the filtered equations are thinned out
    dead_zone    speed [rad/s or m/s] below which the sign of a measured speed is noise: dry friction is
                 taken as proportional to the speed there, and thinned equations at rest are left out
    """

    derivative: Literal["central", "hat"] | None = None
    cutoff: float | None = None
    order: int = 4
    decimate: int = 1
    dead_zone: float = 0.0


@dataclass(frozen=True)
class Multisine:
    """Feed-forward torque: `lines` equally spaced frequencies [Hz], rms torque per joint [N m or N]."""

    rms: tuple[float, ...]
    lines: int
    lowest: float
    highest: float


@dataclass(frozen=True)
class Identification:
    """Each joint swings as swing/2 (1 - cos(2 pi t / period)) under a multisine torque."""

    swing: tuple[float, ...]
    period: float
    duration: float
    multisine: Multisine


@dataclass(frozen=True)
class Line:
    """The tip goes from `start` to `end` [m] in `duration` [s], at rest at both ends.

    Joints in `locked` (counted from 1) stay at 0.
    """

    start: tuple[float, ...]
    end: tuple[float, ...]
    duration: float
    locked: tuple[int, ...] = ()


@dataclass(frozen=True)
class Robot:
    """A tree of links, one on each joint, with or without pins that close loops.

    joints     the driven joints, numbered from 1; they have the motors, coordinates and laws
    servo      what drives the joints where commands are positions, instead of a controller
    passive    hinges without a motor, numbered on from there
    links      of the joints, then of the passive joints
    closures   pins that make the passive joints follow
    tip        from the joint of link `tip_link` (None: the last link) [m]
    transmission  how logs of the motor side are referred to the joints; None where there are none
    effect_files   Python files whose effects join the catalogue, absolute
    """

    name: str
    joints: tuple[Joint, ...]
    links: tuple[Link, ...]
    tip: tuple[float, ...]
    gravity: tuple[float, ...] = (0.0, 0.0, -9.81)
    controller: Controller | None = None
    servo: Servo | None = None
    columns: Mapping[str, Column] = field(default_factory=dict)
    processing: Processing = Processing()
    identification: Identification | None = None
    line: Line | None = None
    description: str = ""
    passive: tuple[PassiveJoint, ...] = ()
    closures: tuple[Closure, ...] = ()
    tip_link: int | None = None
    transmission: Transmission | None = None
    effect_files: tuple[str, ...] = ()

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        """Another process that receives the robot knows its effects too."""
        self.__dict__.update(state)
        load_effects(self.effect_files)

    @property
    def numbered(self) -> Iterator[tuple[int, Joint]]:
        """The driven joints, counted from 1."""
        return enumerate(self.joints, start=1)

    @property
    def parents(self) -> tuple[int, ...]:
        """Per link the number of the link before it, 0 for the base."""
        listed = (*self.joints, *self.passive)
        return tuple(k if joint.parent is None else joint.parent for k, joint in enumerate(listed))

    @property
    def last_link(self) -> int:
        """Number of the link that carries the tip."""
        return self.tip_link or len(self.links)

    @property
    def following(self) -> np.ndarray:
        """(passive, n): angles of the passive joints per unit of `coordinates`."""
        names = self.coordinates
        rows = np.zeros((len(self.passive), len(names)))
        for row, joint in zip(rows, self.passive, strict=True):
            for k, factor in joint.follows.items():
                row[names.index(f"joint{k}.e")] = factor
                if self.joints[k - 1].flexible:
                    row[names.index(f"joint{k}.eps[1]")] = factor
        return rows

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of q: every e first, then every eps."""
        e = [f"joint{k}.e" for k, _ in self.numbered]
        eps = [f"joint{k}.eps[{i}]" for k, joint in self.numbered for i in joint.deformations]
        return tuple(e + eps)

    @property
    def parameters(self) -> dict[str, float]:
        """Every dynamic parameter by its public name, links first (the order of eq. (11))."""
        of_links = {
            f"link{k}.{name}": value
            for k, link in enumerate(self.links, start=1)
            for name, value in link.values.items()
        }
        of_joints = {
            parameter_name(k, effect, name): self.joints[k - 1].values[effect][name]
            for effect in self._effect_order()
            for k, joint in self.numbered
            if effect in joint.values
            for name in joint.values[effect]
        }
        return of_links | of_joints

    @property
    def linear_parameters(self) -> dict[str, float]:
        """Those of `parameters` that have a column in Φ; the others enter their laws nonlinearly."""
        fixed = {
            parameter_name(k, law.name, p.name)
            for k, joint in self.numbered
            for law in joint.effects
            for p in law.nonlinear
        }
        return {name: value for name, value in self.parameters.items() if name not in fixed}

    @property
    def units(self) -> dict[str, str]:
        """Unit of every parameter, in FMI's notation; a slider has m and N where a hinge has rad and N.m."""
        units = {f"link{k + 1}.{p}": u for k in range(len(self.links)) for p, u in LINK_PARAMETERS.items()}
        for k, joint in self.numbered:
            for effect in joint.effects:
                for p in effect.parameters:
                    units[parameter_name(k, effect.name, p.name)] = unit_at(joint, p.unit)
        return {name: units[name] for name in self.parameters}

    def with_parameters(self, values: Mapping[str, float], name: str | None = None) -> "Robot":
        """The same robot with other values; every key must be one of `parameters`."""
        unknown = set(values) - set(self.parameters)
        if unknown:
            raise RobotError(f"robot {self.name} has no parameter {sorted(unknown)[0]}")
        new = self.parameters | {k: float(v) for k, v in values.items()}
        links = tuple(
            Link.of_values({p: new[f"link{k}.{p}"] for p in LINK_PARAMETERS})
            for k, _ in enumerate(self.links, start=1)
        )
        joints = tuple(replace(joint, values=_renew(k, joint.values, new)) for k, joint in self.numbered)
        return replace(self, name=name or self.name, links=links, joints=joints)

    def with_effect(self, joint: int, effect: str) -> "Robot":
        """The same robot with one more law at `joint` (from 1), its parameters at their start values."""
        if effect not in CATALOGUE:
            raise RobotError(f"unknown effect {effect!r}; known are {', '.join(sorted(CATALOGUE))}")
        if not 1 <= joint <= len(self.joints):
            raise RobotError(f"robot {self.name} has no joint {joint}; it has 1 to {len(self.joints)}")
        old = self.joints[joint - 1]
        wrong = objection(CATALOGUE[effect], old.deformations, old.kind, joint, len(self.joints))
        if wrong:
            raise RobotError(f"robot {self.name}: effect {effect} {wrong}")
        start = {p.name: p.start for p in old.law(effect).parameters}
        changed = replace(old, values={**old.values, effect: start})
        return replace(self, joints=(*self.joints[: joint - 1], changed, *self.joints[joint:]))

    def _effect_order(self) -> list[str]:
        used = {effect for joint in self.joints for effect in joint.values}
        order = ["motor_inertia", "coulomb", "viscous", "offset", "stiffness", "damping"]
        return [n for n in order if n in used] + sorted(used - set(order))


def parameter_name(joint: int, effect: str, parameter: str) -> str:
    """`joint1.coulomb` for a base law, `joint1.stribeck.velocity` for any other."""
    return f"joint{joint}.{parameter}" if effect in BASE else f"joint{joint}.{effect}.{parameter}"


def unit_at(joint: Joint, unit: str) -> str:
    """A hinge's unit as it reads at the joint."""
    if joint.kind == "revolute":
        return unit
    return unit.replace("kg.m2", "kg").replace("N.m", "N").replace("rad", "m")


def _renew(
    k: int, laws: Mapping[str, Mapping[str, float]], new: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    return {
        effect: {name: new[parameter_name(k, effect, name)] for name in values}
        for effect, values in laws.items()
    }
