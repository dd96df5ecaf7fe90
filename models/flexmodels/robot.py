"""What a robot is: its joints and links, their laws, and what drives them.

All vectors in base axes at e = 0 ("zero pose"). A link's frame lies at its joint and is parallel to the
base axes in the zero pose; its mass moments and inertia are about that point (the paper's eq. (1)).
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flexmodels.coordinate import Coordinate, deformation_of, joint_name, motor_of, torque_of
from flexmodels.effects import signals
from flexmodels.effects.effect import Effect
from flexmodels.effects.restriction import objection
from flexmodels.gearing import Transmission
from flexmodels.joint import Joint, parameter_name, unit_at
from flexmodels.link import LINK_PARAMETERS, Link
from flexmodels.loops.linkage import Closure, PassiveJoint
from flexmodels.settings.controller import Controller
from flexmodels.settings.servo import Servo
from flexmodels.settings.settings import Settings


class RobotError(ValueError):
    """A robot description that cannot be used; the message names the key and the cure."""


@dataclass(frozen=True)
class Robot:
    """A tree of links, one on each joint, with or without pins that close loops.

    joints     the driven joints, numbered from 1; they have the motors, coordinates and laws
    servo      what drives the joints where commands are positions, instead of a controller
    settings   of its logs and experiments, which no equation needs
    passive    hinges without a motor, numbered on from there
    links      of the joints, then of the passive joints
    closures   pins that make the passive joints follow
    tip        from the joint of link `tip_link` (None: the last link) [m]
    transmission  how logs of the motor side are referred to the joints; None where there are none
    effect_files   Python files of the joints' own laws, absolute
    """

    name: str
    joints: tuple[Joint, ...]
    links: tuple[Link, ...]
    tip: tuple[float, ...]
    gravity: tuple[float, ...] = (0.0, 0.0, -9.81)
    controller: Controller | None = None
    servo: Servo | None = None
    settings: Settings = field(default_factory=Settings)
    description: str = ""
    passive: tuple[PassiveJoint, ...] = ()
    closures: tuple[Closure, ...] = ()
    tip_link: int | None = None
    transmission: Transmission | None = None
    effect_files: tuple[str, ...] = ()

    @property
    def numbered(self) -> Iterator[tuple[int, Joint]]:
        """The driven joints, counted from 1."""
        return enumerate(self.joints, start=1)

    @property
    def joint_numbers(self) -> dict[str, int]:
        """Every name of a driven joint and its number: its own, where no other has it, and `joint{k}`."""
        own = Counter(joint.name for joint in self.joints)
        named = {joint.name: k for k, joint in self.numbered if joint.name and own[joint.name] == 1}
        return named | {joint_name(k): k for k, _ in self.numbered}

    @property
    def flexible(self) -> bool:
        """Whether any of its driven joints bends."""
        return any(joint.flexible for joint in self.joints)

    @property
    def catalogue(self) -> Mapping[str, Effect]:
        """Every law that may act at its joints: those that ship, and its own."""
        return self.joints[0].catalogue

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
                row[names.index(motor_of(k))] = factor
                if self.joints[k - 1].flexible:
                    row[names.index(deformation_of(k))] = factor
        return rows

    @property
    def q(self) -> tuple[Coordinate, ...]:
        """The generalised coordinates: every e first, then every eps."""
        e = [Coordinate(k, "e", unit=unit_at(joint, "rad")) for k, joint in self.numbered]
        eps = [Coordinate(k, "eps", i) for k, joint in self.numbered for i in joint.deformations]
        return tuple(e + eps)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of q, the columns of a log that hold them."""
        return tuple(coordinate.name for coordinate in self.q)

    @property
    def torques(self) -> tuple[str, ...]:
        """Columns of a log that hold the motors' torques."""
        return tuple(torque_of(k) for k, _ in self.numbered)

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
        """Unit of every parameter, in FMI's notation; a slider has m and N where a hinge has rad and N.m.

        What acts on deformations alone keeps rad and N.m: these are turns behind a slider, too.
        """
        units = {f"link{k + 1}.{p}": u for k in range(len(self.links)) for p, u in LINK_PARAMETERS.items()}
        for k, joint in self.numbered:
            for effect in joint.effects:
                bends = bool(effect.forces) and signals.e not in effect.forces
                for p in effect.parameters:
                    unit = p.unit if bends else unit_at(joint, p.unit)
                    if p.periodic and joint.kind == "prismatic":
                        unit = "rad/m"  # of a wave along the slider
                    units[parameter_name(k, effect.name, p.name)] = unit
        return {name: units[name] for name in self.parameters}

    def with_parameters(self, values: Mapping[str, float], name: str | None = None) -> "Robot":
        """The same robot with other values; every key must be one of `parameters`. Raises RobotError."""
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

    def with_settings(self, **changes: Any) -> "Robot":
        """The same robot with other `settings`; keys are fields of Settings."""
        return replace(self, settings=replace(self.settings, **changes))

    def with_effect(self, joint: int, effect: str) -> "Robot":
        """The same robot with one more law at `joint` (from 1), its parameters at their start values.

        Raises RobotError.
        """
        if effect not in self.catalogue:
            raise RobotError(f"unknown effect {effect!r}; known are {', '.join(sorted(self.catalogue))}")
        if not 1 <= joint <= len(self.joints):
            raise RobotError(f"robot {self.name} has no joint {joint}; it has 1 to {len(self.joints)}")
        old = self.joints[joint - 1]
        wrong = objection(self.catalogue[effect], old.deformations, old.kind, joint, len(self.joints))
        if wrong:
            raise RobotError(f"robot {self.name}: effect {effect} {wrong}")
        start = {p.name: p.start for p in old.law(effect).parameters}
        changed = replace(old, values={**old.values, effect: start})
        return replace(self, joints=(*self.joints[: joint - 1], changed, *self.joints[joint:]))

    def without_effect(self, effect: str, joint: int | None = None) -> "Robot":
        """The same robot with no such law at `joint` (from 1), None: at any joint."""
        joints = list(self.joints)
        for k, old in self.numbered:
            if joint in (None, k):
                kept = {law: values for law, values in old.values.items() if law != effect}
                joints[k - 1] = replace(old, values=kept)
        return replace(self, joints=tuple(joints))

    def _effect_order(self) -> list[str]:
        used = {effect for joint in self.joints for effect in joint.values}
        order = ["motor_inertia", "coulomb", "viscous", "offset", "stiffness", "damping"]
        return [n for n in order if n in used] + sorted(used - set(order))


def _renew(
    k: int, laws: Mapping[str, Mapping[str, float]], new: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    return {
        effect: {name: new[parameter_name(k, effect, name)] for name in values}
        for effect, values in laws.items()
    }
