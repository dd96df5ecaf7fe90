"""Where a robot's joints and tip are: the lines that the 3D view draws."""

import numpy as np
import pandas as pd

from flexmodels.coordinate import deformation_of, motor_of
from flexmodels.robot import Robot


def skeleton(robot: Robot, frame: pd.DataFrame | None = None) -> np.ndarray:
    """Points (T, joints + 1, 3) [m] of every joint and the tip, in base axes.

    frame          signals `joint{k}.e` and `joint{k}.eps[i]` over T samples; None: the zero pose, T = 1
    """
    from scipy.spatial.transform import Rotation

    samples = 1 if frame is None else len(frame)
    origin = np.zeros((samples, 3))
    turned = {0: (Rotation.identity(samples), origin)}
    points = []
    for k, joint in robot.numbered:
        parent = robot.parents[k - 1]
        R, x = turned[parent]
        at = x + R.apply(np.tile(joint.origin, (samples, 1)))
        move = _signal(frame, motor_of(k), samples)
        axes = joint.triad
        if joint.kind == "prismatic":
            at = at + R.apply(move[:, None] * axes[:, 0])
            own = R
        else:
            own = R * Rotation.from_rotvec(move[:, None] * axes[:, 0])
        eps = [_signal(frame, deformation_of(k, i), samples) for i in (1, 2, 3)]
        own = own * Rotation.from_rotvec(_bend(eps[1], eps[2]) @ axes.T)
        own = own * Rotation.from_rotvec(eps[0][:, None] * axes[:, 0])
        turned[k] = own, at
        points.append(at)
    last = min(robot.last_link, len(robot.joints))
    R, x = turned[last]
    points.append(x + R.apply(np.tile(robot.tip, (samples, 1))))
    return np.stack(points, axis=1)


def segments(robot: Robot) -> list[tuple[int, int]]:
    """Pairs of points of `skeleton` that a link joins; -1 is the base."""
    pairs = [(robot.parents[k - 1] - 1, k - 1) for k, _ in robot.numbered]
    return [*pairs, (min(robot.last_link, len(robot.joints)) - 1, len(robot.joints))]


def _signal(frame: pd.DataFrame | None, name: str, samples: int) -> np.ndarray:
    if frame is None or name not in frame:
        return np.zeros(samples)
    return frame[name].to_numpy(dtype=float)


def _bend(eps2: np.ndarray, eps3: np.ndarray) -> np.ndarray:
    """(T, 3) rotation vector, in the hinge's triad, that takes its x' to (c, eps2, eps3) the shortest way."""
    sine = np.minimum(np.hypot(eps2, eps3), 1.0)
    factor = np.divide(np.arcsin(sine), sine, out=np.ones_like(sine), where=sine > 0)
    return np.column_stack([np.zeros_like(eps2), -factor * eps3, factor * eps2])
