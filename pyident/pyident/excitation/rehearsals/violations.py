"""Where a motion breaks a limit, or a link comes too near."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from flexmodels.coordinate import motor_of, torque_of
from flexmodels.robot import Robot
from pyident.excitation.capsules import Geometry, clearances
from pyident.excitation.fourier import Reference
from pyident.excitation.limits import Limits

_ROUNDING = 1e-9
_AT_REST = 0.01  # of a speed: below, a motion begins and ends at rest
_UNITS = {
    "position": ("rad", "m"),
    "speed": ("rad/s", "m/s"),
    "acceleration": ("rad/s2", "m/s2"),
    "torque": ("N.m", "N"),
}


@dataclass(frozen=True)
class Violation:
    """what: `position`, `speed`, `acceleration`, `torque`, `distance` or `rest`; where: joint or links.

    value, limit   at the worst sample, at `time` [s]
    of             whose: the reference's, or the simulated robot's
    """

    what: str
    where: str
    value: float
    limit: float
    unit: str
    time: float
    of: str

    @property
    def sentence(self) -> str:
        if self.what == "distance":
            kept = f", their limit is {self.limit:.3g} m" if self.limit else ""
            return (
                f"{self.where} come within {self.value:.3g} m of each other at {self.time:.3g} s "
                f"({self.of}){kept}"
            )
        if self.what == "rest":
            does = "starts" if self.time == 0 else "ends"
            jump = f"{self.value:.3g} {self.unit}"
            return f"{self.where}: {self.of} {does} at {jump} and not at rest, so its speed jumps"
        return (
            f"{self.where}: the {self.what} of {self.of} reaches {self.value:.4g} {self.unit} at "
            f"{self.time:.3g} s, its limit is {self.limit:.4g} {self.unit}"
        )


def of_reference(robot: Robot, limits: Limits, geometry: Geometry, motion: Reference) -> list[Violation]:
    """Of a commanded motion."""
    frame = pd.DataFrame(motion.q, columns=[motor_of(k) for k, _ in robot.numbered])
    own = "the reference"
    return [
        *_ranges(robot, limits, motion.time, motion.q, own),
        *_sizes(robot, "speed", limits.speed, motion.time, motion.dq, own),
        *_sizes(robot, "acceleration", limits.acceleration, motion.time, motion.ddq, own),
        *_near(geometry, motion.time, frame, own),
    ]


def ends(motion: Reference) -> np.ndarray:
    """(2, joints) speeds at the first and the last sample, exact where the acceleration there is even."""
    step = motion.time[1] - motion.time[0]
    return np.array([-3 * q[0] + 4 * q[1] - q[2] for q in (motion.q, -motion.q[::-1])]) / (2 * step)


def at_rest(motion: Reference, speed: np.ndarray) -> np.ndarray:
    """(2, joints) whether a motion begins and ends at rest, as far as a part of `speed` (joints,) goes."""
    return np.abs(ends(motion)) <= _AT_REST * speed


def of_ends(robot: Robot, limits: Limits, motion: Reference) -> list[Violation]:
    """Joints whose speed jumps where a motion begins or ends."""
    rest, speeds = at_rest(motion, limits.speed), ends(motion)
    return [
        Violation(
            "rest",
            f"joint{k}",
            float(speeds[i, k - 1]),
            0.0,
            _UNITS["speed"][joint.kind == "prismatic"],
            float(motion.time[-1] - motion.time[0]) if i else 0.0,
            "the reference",
        )
        for i in (0, 1)
        for k, joint in robot.numbered
        if not rest[i, k - 1]
    ]


def of_run(
    robot: Robot, limits: Limits, geometry: Geometry, frame: pd.DataFrame, of: str = "the simulation"
) -> list[Violation]:
    """Of a simulated robot: its positions, speeds and torques, and where its links are."""
    time = frame["time"].to_numpy()
    q = frame[[motor_of(k) for k, _ in robot.numbered]].to_numpy()
    tau = frame[[torque_of(k) for k, _ in robot.numbered]].to_numpy()
    return [
        *_ranges(robot, limits, time, q, of),
        *_sizes(robot, "speed", limits.speed, time, np.gradient(q, time, axis=0), of),
        *_sizes(robot, "torque", limits.torque, time, tau, of),
        *_near(geometry, time, frame, of),
    ]


def slack(robot: Robot, limits: Limits, geometry: Geometry, frame: pd.DataFrame) -> pd.Series:
    """How far a run stays from every limit, by name: shares of ranges, speeds and torques, distances [m]."""
    time = frame["time"].to_numpy()
    q = frame[[motor_of(k) for k, _ in robot.numbered]].to_numpy()
    tau = frame[[torque_of(k) for k, _ in robot.numbered]].to_numpy()
    span = limits.upper - limits.lower
    shares = {
        "upper end": (limits.upper - q.max(axis=0)) / span,
        "lower end": (q.min(axis=0) - limits.lower) / span,
        "speed": 1 - np.abs(np.gradient(q, time, axis=0)).max(axis=0) / limits.speed,
        "torque": 1 - np.abs(tau).max(axis=0) / limits.torque,
    }
    left = {f"the {of} of joint{k}": share[k - 1] for of, share in shares.items() for k, _ in robot.numbered}
    near = {f"the distance of {c.what}": c.distance.min() - c.least for c in clearances(geometry, frame)}
    return pd.Series(left | near, dtype=float)


def _ranges(robot: Robot, limits: Limits, time: np.ndarray, q: np.ndarray, of: str) -> Iterator[Violation]:
    for k, joint in robot.numbered:
        unit = _UNITS["position"][joint.kind == "prismatic"]
        over, under = q[:, k - 1] - limits.upper[k - 1], limits.lower[k - 1] - q[:, k - 1]
        slack = _ROUNDING * (limits.upper[k - 1] - limits.lower[k - 1])
        for beyond, limit in ((over, limits.upper[k - 1]), (under, limits.lower[k - 1])):
            at = int(np.argmax(beyond))
            if beyond[at] > slack:
                value = float(q[at, k - 1])
                yield Violation("position", f"joint{k}", value, float(limit), unit, float(time[at]), of)


def _sizes(
    robot: Robot, what: str, limit: np.ndarray, time: np.ndarray, values: np.ndarray, of: str
) -> Iterator[Violation]:
    for k, joint in robot.numbered:
        size = np.abs(values[:, k - 1])
        at = int(np.argmax(size))
        if size[at] > limit[k - 1] * (1 + _ROUNDING):
            unit = _UNITS[what][joint.kind == "prismatic"]
            value = float(size[at])
            yield Violation(what, f"joint{k}", value, float(limit[k - 1]), unit, float(time[at]), of)


def _near(geometry: Geometry, time: np.ndarray, frame: pd.DataFrame, of: str) -> Iterator[Violation]:
    for clearance in clearances(geometry, frame):
        at = int(np.argmin(clearance.distance))
        value, least = float(clearance.distance[at]), clearance.least
        if value < least:
            yield Violation("distance", clearance.what, value, least, "m", float(time[at]), of)
