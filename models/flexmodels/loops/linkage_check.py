"""That a robot's passive joints and its closures describe the same loops."""

from collections.abc import Iterator

import numpy as np

from flexmodels.loops.linkage import Closure
from flexmodels.robot import Robot, RobotError

_SWING = 0.4  # of the driven joints in the poses that are tried [rad or m]
_POSES = 8
_OPEN = 1e-9  # [m], and per unit of an axis


def check_linkage(robot: Robot) -> None:
    """Raises RobotError where `follows` lets a pin open.

    `point` is one place in the zero pose, so a pin is closed there by construction; whether it stays closed
    shows when the driven joints move.
    """
    loose = sum(not joint.geared for joint in robot.passive)
    if loose != 2 * len(robot.closures):
        raise RobotError(
            f"closure: a loop has two passive joints and one pin, found {loose} passive joints "
            f"and {len(robot.closures)} closures; one that a gear turns says geared = true"
        )
    for i, closure in enumerate(robot.closures, start=1):
        if closure.links[0] <= len(robot.joints):
            raise RobotError(
                f"closure[{i}].links[1] must be the rod, a link on a passive joint; swap or renumber"
            )
    zero = list(_frames(robot, np.zeros(len(robot.joints))))
    for pose in np.random.default_rng(0).uniform(-_SWING, _SWING, (_POSES, len(robot.joints))):
        moved = list(_frames(robot, pose))
        for i, closure in enumerate(robot.closures, start=1):
            gap = _gap(closure, zero, moved)
            if gap > _OPEN:
                raise RobotError(
                    f"closure[{i}]: the pin opens by {gap:.2g} m when the joints turn by up to {_SWING} rad; "
                    "correct follows, origin, point or axis"
                )


def _frames(robot: Robot, e: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Per link x (3,) and R (3, 3), its axes parallel to the base's at e = 0."""
    angles = [*e, *(sum(f * e[k - 1] for k, f in joint.follows.items()) for joint in robot.passive)]
    found = [(np.zeros(3), np.eye(3))]
    for i, (joint, parent) in enumerate(zip((*robot.joints, *robot.passive), robot.parents, strict=True)):
        x, R = found[parent]
        x = x + R @ joint.origin
        if i < len(robot.joints) and robot.joints[i].kind == "prismatic":
            x = x + R @ joint.x * angles[i]
        else:
            R = R @ _rotation(np.array(joint.x), angles[i])
        found.append((x, R))
        yield x, R


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    cross = np.cross(np.eye(3), -axis)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _gap(closure: Closure, zero: list, moved: list) -> float:
    """Largest distance between where the two links have the pin and its axis."""
    places = []
    for k in closure.links:
        (x0, _), (x, R) = zero[k - 1], moved[k - 1]
        places.append(np.stack([x + R @ (np.array(closure.point) - x0), R @ np.array(closure.axis)]))
    return float(np.abs(places[0] - places[1]).max())
