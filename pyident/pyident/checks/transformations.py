"""What may have happened to the channels of a log, as linear changes that would undo it."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from math import pi

import numpy as np

from flexmodels.coordinate import joint_name, motor_of, torque_of
from flexmodels.robot import Robot
from pyident.rules.equation_checks import EQUATIONS

_MOST_PAIRS = 8  # joints: of more, only neighbours are exchanged
_RATIOS = tuple(
    Fraction(p, q) for p, q in ((1, 2), (2, 3), (3, 4), (3, 5), (4, 5), (5, 8))
)  # and their inverses


@dataclass(frozen=True)
class Transformation:
    """Coordinates become  motion q + offset, torques  torque τ; `mend` says so to the user.

    motion (n, n), offset (n,), torque (joints, joints)
    """

    kind: str
    channel: str
    mend: str
    motion: np.ndarray
    offset: np.ndarray
    torque: np.ndarray

    @property
    def moves(self) -> bool:
        """Whether the motion is changed, not only the torques."""
        return bool(self.offset.any() or (self.motion != np.eye(len(self.motion))).any())

    @property
    def joints(self) -> list[int]:
        """Those (from 0) that it is about."""
        n = len(self.torque)
        motion = np.column_stack([self.motion[:n, :n] - np.eye(n), self.offset[:n]])
        return [k for k in range(n) if motion[k].any() or (self.torque[k] != np.eye(n)[k]).any()]

    def exchanges(self, joint: int) -> bool:
        """Whether it takes this joint's (from 0) position or torque from another joint."""
        row = [matrix[joint] for matrix in (self.motion, self.torque)]
        return self.kind == "order" and any(cells[joint] != 1 for cells in row)


def transformations(robot: Robot, q: np.ndarray) -> Iterator[Transformation]:
    """Orders, signs, zeros, units and ratios, of single joints and of all, that positions q (M, n) allow."""
    yield from _orders(robot)
    yield from _turned(robot)
    yield from _zeros(robot)
    yield from _units(robot, np.abs(q).max(axis=0))
    yield from _ratios(robot)
    yield from _sums(robot)


def _made(
    robot: Robot,
    kind: str,
    channel: str,
    mend: str,
    motion: np.ndarray | None = None,
    offset: np.ndarray | None = None,
    torque: np.ndarray | None = None,
) -> Transformation:
    """motion and offset are given for the joints; deformations stay."""
    n, joints = len(robot.coordinates), len(robot.joints)
    whole = np.eye(n)
    if motion is not None:
        whole[:joints, :joints] = motion
    zero = np.zeros(n)
    if offset is not None:
        zero[:joints] = offset
    return Transformation(kind, channel, mend, whole, zero, np.eye(joints) if torque is None else torque)


def _orders(robot: Robot) -> Iterator[Transformation]:
    n = len(robot.joints)
    orders: dict[str, list[int]] = {}
    pairs = combinations(range(n), 2) if n <= _MOST_PAIRS else ((i, i + 1) for i in range(n - 1))
    for i, j in pairs:
        order = list(range(n))
        order[i], order[j] = j, i
        orders[f"of joints {i + 1} and {j + 1} exchanged"] = order
    if n > 2:
        orders |= {
            "of all joints in reverse order": list(range(n))[::-1],
            "of all joints counted from one joint earlier": [*range(1, n), 0],
            "of all joints counted from one joint later": [n - 1, *range(n - 1)],
        }
    for text, order in orders.items():
        P, first = np.eye(n)[order], next(i for i, j in enumerate(order) if i != j) + 1
        for what, channel, motion, torque in (
            ("torques", torque_of(first), None, P),
            ("positions", motor_of(first), P, None),
            ("columns", joint_name(first), P, P),
        ):
            yield _made(
                robot, "order", channel, f"the {what} {text} fit; check the order of the columns",
                motion, None, torque,
            )  # fmt: skip


def _turned(robot: Robot) -> Iterator[Transformation]:
    n = len(robot.joints)
    for k in range(n):
        turn = np.eye(n)
        turn[k, k] = -1
        for text, motion, torque in ((motor_of(k + 1), turn, None), (torque_of(k + 1), None, turn),
                                     (f"{motor_of(k + 1)} and {torque_of(k + 1)}", turn, turn)):  # fmt: skip
            mend = f"{text} with the other sign fits; give it the sign -1 in the mapping"
            yield _made(robot, "sign", joint_name(k + 1), mend, motion, None, torque)


def _zeros(robot: Robot) -> Iterator[Transformation]:
    for k, joint in robot.numbered:
        if joint.kind != "revolute":
            continue
        for degrees in (90, -90, 180):
            offset = np.zeros(len(robot.joints))
            offset[k - 1] = degrees * pi / 180
            mend = f"{motor_of(k)} with an offset of {degrees}° fits; its zero is not the robot file's"
            yield _made(robot, "zero", motor_of(k), mend, None, offset)


def _units(robot: Robot, reach: np.ndarray) -> Iterator[Transformation]:
    names = {"revolute": (("degrees", pi / 180), ("radians read as degrees", 180 / pi)),
             "prismatic": (("millimetres", 1e-3), ("metres read as millimetres", 1e3))}  # fmt: skip
    n = len(robot.joints)
    alone = [[k] for k in range(n)] if n > 1 else []
    alike = [[k for k in range(n) if robot.joints[k].kind == kind] for kind in names]
    for joints in (*alone, *(of for of in alike if of)):
        for unit, factor in names[robot.joints[joints[0]].kind]:
            if factor < 1 and reach[joints].max() < EQUATIONS.room:
                continue  # a motion made so small that nothing speaks against it
            slides = robot.joints[joints[0]].kind == "prismatic"
            if factor > 1 and slides and factor * reach[joints].max() > EQUATIONS.longest:
                continue  # no slider goes so far
            motion = np.eye(n)
            motion[joints, joints] = factor
            listed = ", ".join(motor_of(k + 1) for k in joints)
            yield _made(robot, "unit", motor_of(joints[0] + 1),
                        f"{listed} taken as {unit} fits; give its unit in the mapping", motion)  # fmt: skip


def _ratios(robot: Robot) -> Iterator[Transformation]:
    """Gears with other teeth than somebody reckoned with. Smaller errors are left to a diagnosis."""
    for k in range(len(robot.joints)):
        for ratio in (*_RATIOS, *(1 / r for r in _RATIOS)):
            motion = np.eye(len(robot.joints))
            motion[k, k] = float(ratio)
            mend = f"{motor_of(k + 1)} times {ratio} fits; correct its gear ratio in the mapping"
            yield _made(robot, "ratio", motor_of(k + 1), mend, motion)


def _sums(robot: Robot) -> Iterator[Transformation]:
    n = len(robot.joints)
    if n < 2:
        return
    steps = np.eye(n) - np.eye(n, k=-1)
    for text, motion in (("against the link before", np.linalg.inv(steps)), ("against the base", steps)):
        mend = f"positions that were measured {text} fit; refer them to the robot file's joints"
        yield _made(robot, "sum", motor_of(2), mend, motion)
