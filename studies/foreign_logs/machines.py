"""Robots drawn at random, as they are and as their owner's file has them: rigid, 1 to 7 joints."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot

Kind = Literal["revolute", "prismatic"]
# axes in the zero pose of a few machines that are built
SHAPES: dict[str, str] = {"scara": "zzZz", "six axes": "zyyxyx", "seven axes": "zyzyzyz", "gantry": "XYZ"}
OWNERS_MASSES = (0.05, 0.15)  # how far the file's masses are off


@dataclass(frozen=True)
class Machine:
    """robot: as it is;  coulomb, viscous, rotor: (n,) [N m, N m s/rad, kg m²], of sliders N, N s/m, kg."""

    robot: Robot
    coulomb: np.ndarray
    viscous: np.ndarray
    rotor: np.ndarray

    @property
    def sliders(self) -> np.ndarray:
        """(n,) whether a joint slides."""
        return np.array([j.kind == "prismatic" for j in self.robot.joints])


@dataclass(frozen=True)
class Error:
    """What a file has wrong of a joint: a `quantity` (origin[x] .. axis[z]), by `amount` [m or rad].

    The true value is the file's plus the amount.
    """

    quantity: str
    joint: int
    amount: float


def drawn_machine(rng: np.random.Generator, most: int = 7) -> Machine:
    """A sixth of the machines has a shape that is built; the others have axes at random, more often few."""
    built = [shape for shape in SHAPES.values() if len(shape) <= most]
    if built and rng.random() < 1 / 6:
        letters = str(rng.choice(built))
        axes = [np.eye(3)["xyz".index(letter.lower())] for letter in letters]
        kinds: list[Kind] = ["prismatic" if letter.isupper() else "revolute" for letter in letters]
    else:
        few = 1 / np.arange(1, most + 1)
        n = 1 + int(rng.choice(most, p=few / few.sum()))
        axes = [_axis(rng, k) for k in range(n)]
        kinds = ["prismatic" if rng.random() < 0.1 else "revolute" for _ in range(n)]
    n, size = len(axes), rng.uniform(0.2, 0.45)
    joints, links, heavy = [], [], rng.uniform(4, 15)
    for k, (axis, kind) in enumerate(zip(axes, kinds, strict=True)):
        origin = rng.normal(size=3) * 0.1 * size + (size if k else 0.0) * _towards(rng)
        joints.append(_joint(kind, axis, origin))
        links.append(_body(rng, heavy * 0.7**k, size))
    robot = Robot(f"machine_{n}", tuple(joints), tuple(links), tip=(size, 0.0, 0.0))
    reach = sum(link.m for link in links) * 9.81 * size * 0.7 ** np.arange(n)  # what moves a joint, roughly
    rotor = 0.3 * reach / 9.81 * size * rng.uniform(0.5, 2, n)
    return Machine(robot, reach * rng.uniform(0.04, 0.15, n), reach * rng.uniform(0.03, 0.15, n), rotor)


def owners_file(machine: Machine, rng: np.random.Generator, errors: tuple[Error, ...]) -> Robot:
    """The rigid robot file: masses off, the geometry wrong by `errors`, starting values of friction."""
    low, high = OWNERS_MASSES
    links = []
    for link in machine.robot.links:
        factor = 1 + rng.choice([-1, 1]) * rng.uniform(low, high)
        links.append(Link.of_values({name: factor * value for name, value in link.values.items()}))
    joints = list(machine.robot.joints)
    for error in errors:
        joints[error.joint - 1] = _wrong(joints[error.joint - 1], error)
    return replace(machine.robot, joints=tuple(joints), links=tuple(links))


def _wrong(joint: Joint, error: Error) -> Joint:
    name, letter = error.quantity[:-1].split("[")
    number = "xyz".index(letter)
    if name == "origin":
        origin = np.array(joint.origin)
        origin[number] -= error.amount
        return replace(joint, origin=tuple(origin.tolist()))
    turn = Rotation.from_rotvec(-error.amount * joint.triad[:, number])
    return replace(joint, x=tuple(turn.apply(joint.x).tolist()), y=tuple(turn.apply(joint.y).tolist()))


def _axis(rng: np.random.Generator, k: int) -> np.ndarray:
    """Along a base axis, or skew; never the first of all along gravity, where it would move little."""
    if rng.random() < 0.3:
        axis = rng.normal(size=3)
        return axis / np.linalg.norm(axis)
    return np.eye(3)[rng.integers(0, 2 if k == 0 else 3)]


def _towards(rng: np.random.Generator) -> np.ndarray:
    return np.eye(3)[rng.integers(0, 3)]


def _joint(kind: Kind, axis: np.ndarray, origin: np.ndarray) -> Joint:
    other = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    y = other / np.linalg.norm(other)
    values = {
        "motor_inertia": {"J_m": 0.1},
        "coulomb": {"coulomb": 1.0},
        "viscous": {"viscous": 1.0},
        "offset": {"offset": 0.0},
    }
    x, across, at = (tuple(float(v) for v in vector) for vector in (axis, y, origin))
    return Joint(kind, x, across, at, flexible=False, values=values)


def _body(rng: np.random.Generator, mass: float, size: float) -> Link:
    """A block as long as the link is, turned at random."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    sides = np.square(rng.uniform([0.5, 0.2, 0.2], [1.0, 0.5, 0.5]) * size)
    inertia = mass / 12 * np.diag(sides.sum() - sides)
    return Link.of_centre(
        mass * rng.uniform(0.7, 1.3), rng.normal(size=3) * size / 3, turn @ inertia @ turn.T
    )
