"""A driven joint: where it sits, how it moves and which laws act at it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from flexmodels.coordinate import of_joint
from flexmodels.effects import BASE, CATALOGUE
from flexmodels.effects.effect import Effect
from flexmodels.effects.restriction import restricted


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
    own       the robot's own laws by name, beside those of the catalogue
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
    own: Mapping[str, Effect] = field(default_factory=dict, compare=False, repr=False)

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
        """A law as it acts here: on the coordinates that the joint has."""
        return restricted(self.catalogue[effect], self.deformations)

    @property
    def catalogue(self) -> Mapping[str, Effect]:
        """Every law that may act here: those that ship, and the robot's own."""
        return {**CATALOGUE, **self.own} if self.own else CATALOGUE

    @property
    def effects(self) -> tuple[Effect, ...]:
        return tuple(self.law(name) for name in self.values)


def parameter_name(joint: int, effect: str, parameter: str) -> str:
    """`joint1.coulomb` for a base law, `joint1.stribeck.velocity` for any other."""
    return of_joint(joint, parameter if effect in BASE else f"{effect}.{parameter}")


def unit_at(joint: Joint, unit: str) -> str:
    """A hinge's unit as it reads at the joint."""
    if joint.kind == "revolute":
        return unit
    return unit.replace("kg.m2", "kg").replace("(N m)", "N").replace("N.m", "N").replace("rad", "m")
