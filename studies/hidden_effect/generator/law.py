"""Laws that a generated robot may hide: other forms than those a tool would try to fit.

Each law draws its constants from a seed, relative to the levels that the plain robot shows (`Levels`), and
adds itself to an Arm. `amplitude` scales what makes the law strong; 1 means that its torque is some 10-25 %
of the rms torque of its row, or clearly visible otherwise.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np

from flexmodels.coordinate import of_joint

from .model import SMOOTH, Arm

SX = Any
Constants = dict[str, float]


@dataclass(frozen=True)
class Levels:
    """What the plain robot shows: rms of motor torques and transmission torques, peaks of torques.

    torque, load, peak   per joint [N m];  speed per joint, rms [rad/s]
    twist                per joint, rms of eps1 [rad]
    values               parameters of the robot
    """

    torque: np.ndarray
    load: np.ndarray
    peak: np.ndarray
    speed: np.ndarray
    twist: np.ndarray
    values: Mapping[str, float]

    def of(self, k: int, name: str) -> float:
        return self.values[of_joint(k, name)]


@dataclass(frozen=True)
class Draw:
    """Where constants come from: a random generator, the joint, the levels and the amplitude."""

    rng: np.random.Generator
    k: int
    levels: Levels
    amplitude: float = 1.0

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def sign(self) -> float:
        return float(self.rng.choice([-1.0, 1.0]))

    def phase(self) -> float:
        return self.between(0, 2 * np.pi)

    def strong(self, low: float, high: float, level: float) -> float:
        return self.amplitude * self.between(low, high) * level

    def torque(self, low: float, high: float) -> float:
        return self.strong(low, high, float(self.levels.torque[self.k - 1]))

    def load(self, low: float, high: float) -> float:
        return self.strong(low, high, float(self.levels.load[self.k - 1]))

    def value(self, name: str) -> float:
        return self.levels.of(self.k, name)


@dataclass(frozen=True)
class Law:
    """A hidden law.

    draw       constants from a Draw
    add        puts the law into an arm: arm, joint, constants as symbols, constants as numbers
    joints     where it may sit; None: anywhere
    per_log    constants that each log draws anew, with their ranges
    tilting    whether the base needs its two tilts
    catalogue  False for what no catalogue lists
    """

    name: str
    draw: Callable[[Draw], Constants]
    add: Callable[[Arm, int, dict[str, SX], Constants], None]
    joints: tuple[int, ...] | None = None
    per_log: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    tilting: bool = False
    catalogue: bool = True


LAWS: dict[str, Law] = {}


def law(name: str, draw: Callable[[Draw], Constants], **options):
    """Register the decorated function as the `add` of a law."""

    def register(add):
        LAWS[name] = Law(name, draw, add, **options)
        return add

    return register


def dry(v: SX) -> SX:
    """Smooth sign of a speed."""
    return ca.tanh(v / SMOOTH)


def dead_zone(x: SX, half: SX, width: SX) -> SX:
    """x without its part between -half and half, with rounded corners."""
    return x + (ca.sqrt((x - half) ** 2 + width**2) - ca.sqrt((x + half) ** 2 + width**2)) / 2
