"""What other formats share: bodies lumped at joints and back, triads, hinges put in."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot, RobotError

Body = tuple[float, np.ndarray, np.ndarray]  # mass [kg], centre [m], inertia about it [kg m2], base axes

_ROUNDING = 1e-9  # of an inertia's size: what a principal value may miss
_HINGE_FREQUENCY = 10.0  # [Hz] of a nominal flexible hinge: a start, not a measurement
_HINGE_DAMPING = 0.02  # of critical, likewise


def triad_along(axis: np.ndarray, name: str) -> np.ndarray:
    """(3, 3): x' along `axis` (3,), y' along the frame's axis after the nearest one. Raises RobotError."""
    length = np.linalg.norm(axis)
    if not length > 0:
        raise RobotError(f"joint {name} has an axis of zero length; write down its direction")
    x = axis / length
    y = np.eye(3)[(int(np.argmax(np.abs(x))) + 1) % 3]
    y = y - x * (x @ y)
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def lumped(bodies: list[Body], at: np.ndarray) -> Link:
    """Bodies that move together as one, about the joint at `at` (3,) [m]."""
    parts = [tuple(Link.of_centre(m, centre - at, J).values.values()) for m, centre, J in bodies]
    total = np.sum(parts, axis=0) if parts else np.zeros(10)
    return Link(float(total[0]), plain(total[1:4]), plain(total[4:]))


def centred(link: Link, k: int) -> Body:
    """A link's mass, centre and inertia about it; of a point or a rod, principal values of exactly zero.

    k: its number, for the sentence of the RobotError that is raised where no rigid body has such values.
    """
    if link.m <= 0:
        raise RobotError(f"link {k} has moments of mass but no mass, as no rigid body has; give it one")
    com, J = link.about_centre()
    principal, axes = np.linalg.eigh(J)
    if principal.sum() - 2 * principal.max() < -_ROUNDING * np.abs(link.J).max():
        raise RobotError(
            f"link {k} has principal inertias {', '.join(f'{p:.3g}' for p in principal)} kg m2 about "
            "its centre of mass, which no rigid body has; identify the robot, or correct its J"
        )
    return link.m, com, axes * np.maximum(principal, 0.0) @ axes.T


def with_hinges(
    robot: Robot,
    flexible: list[int],
    twist: list[int],
    bodies: Sequence[list[Body]],
    places: Sequence[np.ndarray],
) -> Robot:
    """The robot with flexible hinges at joints (from 1), stiffness and damping at their placeholders.

    bodies, places   per link, 0 being the base: what it is made of, and where its joint is [m]
    Raises RobotError.
    """
    for k in (*flexible, *twist):
        if not 1 <= k <= len(robot.joints):
            raise RobotError(f"there is no joint {k} to make flexible; robot {robot.name} has 1 to "
                             f"{len(robot.joints)}")  # fmt: skip
    if both := set(flexible) & set(twist):
        raise RobotError(f"joint {min(both)} cannot both bend and only twist; name it once")
    joints = [
        _flexible(joint, k in flexible, _inertias(robot, bodies, places, k))
        if k in (*flexible, *twist)
        else joint
        for k, joint in robot.numbered
    ]
    return replace(robot, joints=tuple(joints))


def _flexible(joint: Joint, bends: bool, inertias: np.ndarray) -> Joint:
    if joint.kind == "prismatic":
        raise RobotError(f"joint {joint.name} is a slider, which has no flexible hinge here; leave it rigid")
    k = np.maximum(inertias, 1e-6) * (2 * np.pi * _HINGE_FREQUENCY) ** 2
    d = 2 * _HINGE_DAMPING * k / (2 * np.pi * _HINGE_FREQUENCY)
    axes = (1, 2, 3) if bends else (1,)
    hinge = {
        "stiffness": {f"k[{i}]": float(k[i - 1]) for i in axes},
        "damping": {f"d[{i}]": float(d[i - 1]) for i in axes},
    }
    return replace(joint, flexible=True, bends=bends, values={**joint.values, **hinge})


def _inertias(robot: Robot, bodies: Sequence[list[Body]], places: Sequence[np.ndarray], k: int) -> np.ndarray:
    """Of everything behind joint k in the zero pose, about x', z' and y' (twist and the two bendings)."""
    moved = [n for n in range(1, len(robot.links) + 1) if k in _ancestry(robot, n)]
    xx, xy, xz, yy, yz, zz = lumped([body for n in moved for body in bodies[n]], places[k]).J
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    triad = robot.joints[k - 1].triad
    return np.diag(triad.T @ J @ triad)[[0, 2, 1]]


def _ancestry(robot: Robot, link: int) -> list[int]:
    chain = []
    while link:
        chain.append(link)
        link = robot.parents[link - 1]
    return chain


def plain(vector: np.ndarray) -> tuple[float, ...]:
    """A vector (n,) as a robot holds it."""
    return tuple(float(v) for v in vector)
