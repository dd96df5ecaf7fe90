"""Links as capsules about the lines between their joints: how near they come to each other and the floor."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from flexmodels.robot import Robot
from pyident.kinematics.skeleton import segments, skeleton

_RADIUS = 0.06  # of the robot's length, where nothing tells how thick its links are
_BESIDE = 3.0  # radii of a link next to another that are left out
_SHORT = 1e-6  # m: a link without extension


@dataclass(frozen=True)
class Geometry:
    """radius [m] of every link; floor: its height [m] against gravity from the base, None: there is none.

    pairs   of links (rows of `segments`) that could collide, and the share of the second one's beginning that
            is left out, because it is built next to the first
    grounded  links that could meet the floor
    up      unit vector against gravity
    notes   what is not looked at, a sentence each
    """

    robot: Robot
    radius: float
    floor: float | None
    pairs: tuple[tuple[int, int, float], ...]
    grounded: tuple[int, ...]
    up: np.ndarray
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Clearance:
    """what comes near what; distance (N,) [m] between their surfaces, negative inside each other."""

    what: str
    distance: np.ndarray


def geometry_of(robot: Robot, radius: float | None = None, floor: float | None = 0.0) -> Geometry:
    """Capsules of a robot. What touches in the zero pose is taken to be built that way, and left out."""
    points = skeleton(robot)
    lines = segments(robot)
    lengths = [float(np.linalg.norm(_end(points, b) - _end(points, a))) for a, b in lines]
    given = radius is not None
    radius = _RADIUS * sum(lengths) if radius is None else radius
    notes = [] if given else [f"links are taken as {radius:.3g} m thick about the lines between their joints"]
    g = np.array(robot.gravity)
    up = -g / np.linalg.norm(g) if np.linalg.norm(g) > 0 else np.array([0.0, 0.0, 1.0])
    if not np.any(g):
        floor = None
        notes.append("there is no gravity, so there is no floor")
    pairs, grounded = [], []
    solid = [i for i, length in enumerate(lengths) if length > _SHORT]
    for i, j in combinations(solid, 2):
        if set(lines[i]) & set(lines[j]):
            continue  # neighbours share a joint
        for left_out in (0.0, min(_BESIDE * radius / lengths[j], 1.0)):
            if _apart(points, lines[i], lines[j], left_out)[0] > 2 * radius:
                pairs.append((i, j, left_out))
                break
        else:
            both = f"{_name(lines[i])} and {_name(lines[j])}"
            notes.append(f"{both} touch in the zero pose and are not watched")
    for i in solid:
        low = min(float(end[0] @ up) for end in _line(points, lines[i])) - radius
        if floor is not None and low > floor:
            grounded.append(i)
    if robot.passive:
        notes.append("rods that passive joints carry are not watched")
    return Geometry(robot, radius, floor, tuple(pairs), tuple(grounded), up, tuple(notes))


def clearances(geometry: Geometry, frame: pd.DataFrame) -> list[Clearance]:
    """Of every pair and every link over the floor, along N samples of `joint{k}.e` and `joint{k}.eps[i]`."""
    points = skeleton(geometry.robot, frame)
    lines = segments(geometry.robot)
    out = [
        Clearance(
            f"{_name(lines[i])} and {_name(lines[j])}",
            _apart(points, lines[i], lines[j], left_out) - 2 * geometry.radius,
        )
        for i, j, left_out in geometry.pairs
    ]
    if geometry.floor is not None:
        for i in geometry.grounded:
            low = np.minimum(*(end @ geometry.up for end in _line(points, lines[i])))
            out.append(Clearance(f"{_name(lines[i])} and the floor", low - geometry.radius - geometry.floor))
    return out


def between(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """(N,) distances of the segments ab and cd, points (N, 3).

    Least distance of two segments: inside both where their lines allow, else from an end to the other
    segment (Ericson, Real-Time Collision Detection, 2005, 5.1.9).
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv, uw, vw = (np.einsum("ni,ni->n", x, y) for x, y in ((u, u), (v, v), (u, v), (u, w), (v, w)))
    tiny = 1e-15
    denominator = uu * vv - uv**2
    skew = denominator > 1e-12 * uu * vv
    s = np.where(skew, np.clip((uv * vw - uw * vv) / np.where(skew, denominator, 1.0), 0, 1), 0.0)
    t = np.clip((uv * s + vw) / np.maximum(vv, tiny), 0, 1)
    s = np.clip((uv * t - uw) / np.maximum(uu, tiny), 0, 1)
    return np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)


def _end(points: np.ndarray, number: int) -> np.ndarray:
    """(N, 3) of a point of the skeleton; -1 is the base."""
    return np.zeros((len(points), 3)) if number < 0 else points[:, number]


def _line(points: np.ndarray, line: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    return _end(points, line[0]), _end(points, line[1])


def _apart(
    points: np.ndarray, first: tuple[int, int], second: tuple[int, int], left_out: float
) -> np.ndarray:
    """(N,) distances of two links' lines, the second without a share of its beginning."""
    c, d = _line(points, second)
    return between(*_line(points, first), c + left_out * (d - c), d)


def _name(line: tuple[int, int]) -> str:
    """Of the link that begins at the line's first point."""
    return "the base" if line[0] < 0 else f"link {line[0] + 1}"
