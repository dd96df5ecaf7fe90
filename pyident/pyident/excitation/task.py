"""What is asked of a motion: a robot, its limits, its room, its sensors and how long it may take."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from flexmodels import multisine
from flexmodels.robot import Robot, RobotError
from pyident.conditioning.weak_form import recipe
from pyident.excitation.capsules import Geometry, geometry_of
from pyident.excitation.fourier import Family
from pyident.excitation.limits import Limits, limits_of, where_it_begins
from pyident.excitation.rehearsals.rehearsal import SPREAD
from pyident.logs.log import Log, LogError

ENCODER = 1e-5  # rad or m: noise of an encoder where nothing is known
_TORQUE = 0.01  # of a torque limit: noise of a measured torque where nothing is known
_RATE = 250.0  # Hz, of robots without a controller
_LARGEST = 1e6  # s, Hz, m or a sensor's noise
_FEWEST, _MOST = 10, 1e6  # samples of a plan: fewer hold no motion, more do not fit into a search
_SHARE = 0.95  # of the limits, that a reference may use: the rest is for the loop
_WAVE_SHARE = 0.4  # of a torque limit, that a multisine may take at most
_LOUDEST = 2.0  # times the robot's own multisine, at most
_NOWHERE, _SLOW = 0.02, 0.95  # of a range: a motion that gets less far is none, or is worth a note


@dataclass(frozen=True)
class Task:
    """A robot with what limits it.

    noise    channel -> standard deviation of its sensor
    spread   share by which its parameters may be off
    """

    robot: Robot
    limits: Limits
    geometry: Geometry
    noise: Mapping[str, float]
    duration: float
    rate: float
    spread: float = SPREAD
    harmonics: int = 5
    repeats: int = 1

    @property
    def family(self) -> Family:
        return Family(self.limits.within(_SHARE, 1.0), self.duration, self.harmonics, self.repeats)

    @cached_property
    def multisine(self) -> np.ndarray:
        """(N, joints) torques of the robot's own multisine with flat phases; zero where it has none."""
        time = np.arange(round(self.duration * self.rate) + 1) / self.rate
        plan, joints = self.robot.settings.identification, len(self.robot.joints)
        if plan is None or self.robot.controller is None:
            return np.zeros((len(time), joints))
        tones = plan.multisine
        f = np.linspace(tones.lowest, min(tones.highest, 0.4 * self.rate), tones.lines)
        rng = np.random.default_rng(0)
        phases = [multisine.flattened(rng.uniform(0, 2 * np.pi, tones.lines), f) for _ in range(joints)]
        waves = np.column_stack([multisine.wave(time, f, p) for p in phases]) * np.array(tones.rms)
        fade = np.clip(np.minimum(time, time[-1] - time) / 0.25, 0, 1)[:, None]  # at rest at both ends
        return waves * fade

    @property
    def loudest(self) -> np.ndarray:
        """(joints,) factors of the multisine that the limits of torque allow."""
        peak = np.abs(self.multisine).max(axis=0)
        return np.minimum(_LOUDEST, _WAVE_SHARE * self.limits.torque / np.maximum(peak, 1e-12))


def task_of(
    robot: Robot,
    duration: float,
    rate: float | None,
    limits: Mapping[str, float] | None,
    noise: Mapping[str, float] | None,
    radius: float | None,
    floor: float | None,
    spread: float,
    home: Mapping[str, float] | None = None,
    begin: np.ndarray | None = None,
) -> Task:
    """What the verbs are given, checked; whatever is None is the robot file's or a common value.

    home    joint -> where motions set out;  begin  the pose (joints,) in which a plan does, instead
    Raises RobotError.
    """
    driven = robot.controller or robot.servo
    own = 1 / driven.period if driven else _RATE
    if rate is not None and driven and abs(rate - own) > 1e-6 * own:
        raise RobotError(f"robot {robot.name} is driven at {own:g} Hz; leave the plan at that rate")
    _require(duration, rate or own, radius, floor, noise or {})
    if not 0 < spread < 1:
        raise RobotError(f"parameters cannot be off by {100 * spread:g} %; give a spread above 0 and below 1")
    allowed = limits_of(robot, limits, home)
    if begin is not None:
        allowed = replace(allowed, home=begin)
    known = {name: ENCODER for name in robot.coordinates}
    if robot.controller is None:
        sizes = zip(robot.torques, allowed.torque, strict=True)
        known |= {name: _TORQUE * float(size) for name, size in sizes if size < float("inf")}
    unknown = set(noise or {}) - {*robot.coordinates, *robot.torques}
    if unknown:
        raise RobotError(
            f"robot {robot.name} has no sensor {min(unknown)}; they are {robot.coordinates[0]} and so on"
        )
    shape = geometry_of(robot, radius, floor, allowed.home)
    return Task(robot, allowed, shape, known | dict(noise or {}), duration, rate or own, spread)


def _require(
    duration: float, rate: float, radius: float | None, floor: float | None, noise: Mapping[str, float]
) -> None:
    """Raises RobotError for numbers that no motion, link or sensor has."""
    named = [("the duration", duration), ("the rate", rate)]
    named += [(f"the noise of {name}", size) for name, size in noise.items()]
    if radius is not None:
        named.append(("the radius", radius))
    for name, value in named:
        if not 0 < value < _LARGEST:
            raise RobotError(f"{name} of a plan is {value:g}; it must be above zero and below {_LARGEST:g}")
    if floor is not None and not abs(floor) < _LARGEST:
        raise RobotError(f"a floor at {floor:g} m is none; leave it out (--no-floor)")
    if not _FEWEST <= duration * rate < _MOST:
        raise RobotError(
            f"{duration:g} s at {rate:g} Hz are {duration * rate:.3g} samples; "
            f"a plan has from {_FEWEST} to {_MOST:g}"
        )


def require_over_the_floor(task: Task) -> None:
    """Raises RobotError where a motion would begin with links that lie wholly below the floor."""
    if task.geometry.sunk:
        begin = where_it_begins(task.robot, task.limits)
        raise RobotError(
            f"robot {task.robot.name}: a motion begins {begin}, where {task.geometry.sunk[0]} is below the "
            f"floor at {task.geometry.floor:g} m over the base; give another --floor, or --no-floor"
        )


def require_long_enough(task: Task) -> None:
    """Raises RobotError where a log of the plan would be refused by the robot's [processing]."""
    robot, samples = task.robot, range(round(task.duration * task.rate) + 1)
    rest = pd.DataFrame(0.0, index=samples, columns=[*robot.coordinates, *robot.torques])
    rest.insert(0, "time", rest.index / task.rate)
    try:
        recipe(Log(rest, "a log of the plan"), robot)
    except LogError as error:
        raise RobotError(f"{error}; give a longer duration or, without a controller, a higher rate") from None


def slow(task: Task) -> tuple[str, ...]:
    """A note on joints that cannot get far within a motion. Raises RobotError where none of them can."""
    lower, upper = task.family.room
    share = (upper - lower) / (task.family.limits.upper - task.family.limits.lower)
    if share.max() < _NOWHERE:
        raise RobotError(
            f"a motion of {task.duration:g} s is too short: the limits of speed and acceleration leave the "
            f"joints of robot {task.robot.name} {100 * share.max():.2g} % of their ranges at most"
        )
    named = ", ".join(f"joint{k + 1} {100 * share[k]:.0f} %" for k in np.flatnonzero(share < _SLOW))
    if not named:
        return ()
    return (
        f"in {task.duration:g} s the limits of speed and acceleration leave joints a part of their range "
        f"({named}); a longer motion tells more",
    )
