"""Links as capsules about the lines between their joints: how near they come to each other and the floor."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pandas as pd

from flexmodels.coordinate import motor_of
from flexmodels.robot import Robot
from pyident.kinematics.skeleton import segments, skeleton

_RADIUS = 0.06  # of the robot's length, where nothing tells how thick its links are
_BESIDE = 3.0  # radii of a link next to another that are left out
_SHORT = 1e-6  # m: a link without extension
_SAG = 0.25  # radii that a link may go deeper than it begins where the floor is in its way: arms bend


@dataclass(frozen=True)
class Grounded:
    """A link over the floor: its ends (points of the skeleton) that move, and how near [m] they may come.

    least   0, or negative for a link that reaches below the floor where the motion begins
    """

    name: str
    ends: tuple[int, ...]
    least: float


@dataclass(frozen=True)
class Geometry:
    """radius [m] of every link; floor: its height [m] against gravity from the base, None: there is none.

    pairs   of links (rows of `segments`) that could collide, and the share of the second one's beginning that
            is left out, because it is built next to the first
    grounded  links that could meet the floor
    sunk    names of links that lie wholly below the floor where the motion begins
    up      unit vector against gravity
    notes   what is not looked at, a sentence each
    """

    robot: Robot
    radius: float
    floor: float | None
    pairs: tuple[tuple[int, int, float], ...]
    grounded: tuple[Grounded, ...]
    sunk: tuple[str, ...]
    up: np.ndarray
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Clearance:
    """what comes near what; distance (N,) [m] between their surfaces, negative inside each other.

    least   distance [m] that must be kept
    """

    what: str
    distance: np.ndarray
    least: float = 0.0


def geometry_of(
    robot: Robot, radius: float | None = None, floor: float | None = 0.0, begin: np.ndarray | None = None
) -> Geometry:
    """Capsules of a robot. What touches in the zero pose is taken to be built that way, and left out.

    begin   (joints,) pose [rad or m] in which the motion begins, None: the zero pose. A link that is partly
            below the floor there must not go deeper.
    """
    points = skeleton(robot)
    lengths = [float(np.linalg.norm(_end(points, b) - _end(points, a))) for a, b in segments(robot)]
    given = radius is not None
    radius = _RADIUS * sum(lengths) if radius is None else radius
    notes = [] if given else [f"links are taken as {radius:.3g} m thick about the lines between their joints"]
    g = np.array(robot.gravity)
    up = -g / np.linalg.norm(g) if np.linalg.norm(g) > 0 else np.array([0.0, 0.0, 1.0])
    if not np.any(g):
        floor = None
        notes.append("there is no gravity, so there is no floor")
    pairs, touching = _pairs(robot, points, lengths, radius)
    grounded, sunk, deep = [], [], []
    for link, low, high in _over_ground(robot, lengths, up, begin) if floor is not None else ():
        below = low - radius - (floor or 0.0)
        if below < 0 < high + radius - (floor or 0.0):
            link = replace(link, least=below - _SAG * radius)
            deep.append(link.name)
        elif below < 0:
            sunk.append(link.name)
        grounded.append(link)
    notes += touching
    if deep:
        notes.append(
            f"{_reaching(deep)} below the floor where the motion begins: it is only watched that nothing "
            f"goes more than {_SAG * radius:.2g} m deeper; --floor gives its height over the base"
        )
    if robot.passive:
        notes.append("rods that passive joints carry are not watched")
    return Geometry(robot, radius, floor, pairs, tuple(grounded), tuple(sunk), up, tuple(notes))


def _pairs(
    robot: Robot, points: np.ndarray, lengths: Sequence[float], radius: float
) -> tuple[tuple[tuple[int, int, float], ...], list[str]]:
    """Those of `Geometry`, and a note for each pair that touches."""
    lines = segments(robot)
    pairs, notes = [], []
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
    return tuple(pairs), notes


def _over_ground(
    robot: Robot, lengths: Sequence[float], up: np.ndarray, begin: np.ndarray | None
) -> Iterator[tuple[Grounded, float, float]]:
    """Links with ends that move, and the heights [m] of their lowest and highest one in a pose."""
    pose = np.zeros(len(robot.joints)) if begin is None else begin
    points = skeleton(robot, pd.DataFrame([pose], columns=[motor_of(k) for k, _ in robot.numbered]))
    still = {-1} | {
        k - 1 for k, joint in robot.numbered if robot.parents[k - 1] == 0 and joint.kind == "revolute"
    }
    for line, length in zip(segments(robot), lengths, strict=True):
        ends = tuple(end for end in line if end not in still)
        if length > _SHORT and ends:
            heights = [float(_end(points, end)[0] @ up) for end in ends]
            yield Grounded(_name(line), ends, 0.0), min(heights), max(heights)


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
        for link in geometry.grounded:
            low = np.min([_end(points, end) @ geometry.up for end in link.ends], axis=0)
            distance = low - geometry.radius - geometry.floor
            out.append(Clearance(f"{link.name} and the floor", distance, link.least))
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


def _reaching(names: Sequence[str]) -> str:
    unique = list(dict.fromkeys(names))
    return f"{unique[0]} reaches" if len(unique) == 1 else f"{', '.join(unique[:-1])} and {unique[-1]} reach"
