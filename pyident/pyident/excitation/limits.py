"""What the joints of a robot may do: from its file, from what is given, else from its own experiment."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.experiment import identification
from flexmodels.robot import Robot, RobotError
from pyident.excitation.followed import followed, torques

_LOOP = 0.05  # of what a reference does, that the loop which follows it needs beyond
QUANTITIES = ("lower", "upper", "speed", "acceleration", "torque")


@dataclass(frozen=True)
class Limits:
    """Per joint, (joints,), SI units; inf where nothing limits.

    lower, upper, speed, acceleration, torque
    home     where every motion sets out, at rest
    notes    where the numbers come from, a sentence each
    """

    lower: np.ndarray
    upper: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray
    home: np.ndarray
    notes: tuple[str, ...] = ()

    def within(self, share: float, torque_share: float) -> "Limits":
        """Narrower ones about home: a share of every range, and one of the torque."""
        return replace(
            self,
            lower=self.home + share * (self.lower - self.home),
            upper=self.home + share * (self.upper - self.home),
            speed=share * self.speed,
            acceleration=share * self.acceleration,
            torque=torque_share * self.torque,
        )


def limits_of(
    robot: Robot, given: Mapping[str, float] | None = None, home: Mapping[str, float] | None = None
) -> Limits:
    """Limits by `joint{k}.lower`, `.upper`, `.speed`, `.acceleration`, `.torque`, then those of the file.

    home    joint -> where it sets out [rad or m]; the others do at 0, or amid their range where it has no 0
    Joints have their names `joint{k}` or their own. What is left open is taken from the motion of the robot's
    [identification], an acceleration only where no torque limits it; accelerations and torques may stay open.
    Raises RobotError.
    """
    values = {name: np.full(len(robot.joints), np.nan) for name in QUANTITIES}
    _from_file(robot, values)
    _from_call(robot, values, given or {})
    notes = (*_from_experiment(robot, values), *_of_endless(robot, values, home or {}))
    for name in ("lower", "upper", "speed"):
        for k in np.flatnonzero(np.isnan(values[name])) + 1:
            raise RobotError(
                f"robot {robot.name} has no limit joint{k}.{name}; add [joint.limits] to its file, or give "
                f"--limit joint{k}.{name}=NUMBER"
            )
    for name in ("acceleration", "torque"):
        if np.isnan(values[name]).any():
            notes += (f"nothing limits the {name} of {_listed(np.isnan(values[name]))}",)
            values[name] = np.where(np.isnan(values[name]), np.inf, values[name])
    _check(robot, values)
    return Limits(**values, home=_home(robot, values, home or {}), notes=notes)


def _home(robot: Robot, values: Mapping[str, np.ndarray], given: Mapping[str, float]) -> np.ndarray:
    """(joints,) where motions set out. Raises RobotError."""
    inside = (values["lower"] <= 0) & (values["upper"] >= 0)
    home = np.where(inside, 0.0, (values["lower"] + values["upper"]) / 2)
    for name, position in given.items():
        k = robot.joint_numbers.get(name)
        if k is None:
            raise RobotError(f"there is no {name} that could set out anywhere; {_joints(robot)}")
        lower, upper = values["lower"][k - 1], values["upper"][k - 1]
        if not lower <= position <= upper:
            raise RobotError(
                f"robot {robot.name}: {name} cannot set out at {position:g}, as its limits are {lower:g} and "
                f"{upper:g}"
            )
        home[k - 1] = position
    return home


def amid(robot: Robot, limits: Limits, given: Mapping[str, float]) -> tuple[str, ...]:
    """A note where a motion sets out amid a joint's range, as it has no zero and no `given` place."""
    known = {robot.joint_numbers[name] for name in given}
    chosen = (limits.home != 0) & ~np.isin(np.arange(len(robot.joints)) + 1, list(known))
    if not chosen.any():
        return ()
    place = _positions(robot, limits.home, chosen)
    return (f"a motion sets out with {place}, amid its range, as 0 is outside; --home gives another place",)


def where_it_begins(robot: Robot, limits: Limits) -> str:
    """The pose in which every motion sets out, as a sentence goes on with it."""
    outside = _positions(robot, limits.home, limits.home != 0)
    return f"with {outside}" if outside else "in the zero pose"


def _positions(robot: Robot, home: np.ndarray, which: np.ndarray) -> str:
    return ", ".join(
        f"joint{k} at {home[k - 1]:.3g} {'m' if joint.kind == 'prismatic' else 'rad'}"
        for k, joint in robot.numbered
        if which[k - 1]
    )


def _joints(robot: Robot) -> str:
    """Which joints there are."""
    return f"its joints are {', '.join(robot.joint_numbers)}"


def _from_file(robot: Robot, values: dict[str, np.ndarray]) -> None:
    for k, joint in robot.numbered:
        limits = joint.limits
        if limits is None:
            continue
        if limits.position is not None:
            values["lower"][k - 1], values["upper"][k - 1] = limits.position
        if limits.speed is not None:
            values["speed"][k - 1] = limits.speed
        if limits.effort is not None:
            values["torque"][k - 1] = limits.effort


def _from_call(robot: Robot, values: dict[str, np.ndarray], given: Mapping[str, float]) -> None:
    for name, value in given.items():
        joint, _, quantity = name.rpartition(".")
        k = robot.joint_numbers.get(joint)
        if k is None or quantity not in QUANTITIES:
            raise RobotError(
                f"there is no limit {name}; limits are joint1.{', joint1.'.join(QUANTITIES)} and so on; "
                f"{_joints(robot)}"
            )
        values[quantity][k - 1] = value


def _from_experiment(robot: Robot, values: dict[str, np.ndarray]) -> tuple[str, ...]:
    """What the robot's own identification experiment shows that it may do, where nothing else tells."""
    open_ = {name: np.isnan(v) for name, v in values.items()}
    open_["acceleration"] &= np.isnan(values["torque"])  # where the torque is limited, that limits it
    if robot.settings.identification is None or not any(v.any() for v in open_.values()):
        return ()
    plan = identification(robot)
    period = float(plan.time[1] - plan.time[0])
    q = plan.reference
    dq = np.gradient(q, period, axis=0)
    ddq = np.gradient(dq, period, axis=0)
    coarse = slice(None, None, max(1, len(q) // 400))
    tau = torques(robot, followed(robot, plan.time[coarse], q[coarse], dq[coarse], ddq[coarse]))
    margin = _LOOP * np.ptp(q, axis=0)
    reached = {
        "lower": q.min(axis=0) - margin,
        "upper": q.max(axis=0) + margin,
        "speed": (1 + _LOOP) * np.abs(dq).max(axis=0),
        "acceleration": (1 + _LOOP) * np.abs(ddq).max(axis=0),
        "torque": (1 + _LOOP) * (np.abs(tau).max(axis=0) + np.abs(plan.feedforward).max(axis=0)),
    }
    notes = []
    for name, value in reached.items():
        if open_[name].any():
            values[name] = np.where(open_[name], value, values[name])
            notes.append(
                f"the limit {name} of {_listed(open_[name])} is that of the robot's [identification]"
            )
    return tuple(notes)


def _of_endless(robot: Robot, values: dict[str, np.ndarray], home: Mapping[str, float]) -> tuple[str, ...]:
    """Half a turn either way, where a joint's limits in the file have no position: it turns without end."""
    turning = np.array([joint.kind == "revolute" and joint.limits is not None for joint in robot.joints])
    turning &= np.isnan(values["lower"]) & np.isnan(values["upper"])
    if not turning.any():
        return ()
    begin = np.zeros(len(robot.joints))
    for name in set(home) & set(robot.joint_numbers):
        begin[robot.joint_numbers[name] - 1] = home[name]
    values["lower"] = np.where(turning, begin - np.pi, values["lower"])
    values["upper"] = np.where(turning, begin + np.pi, values["upper"])
    return (
        f"nothing limits the position of {_listed(turning)}: a motion stays within half a turn of its start",
    )


def _check(robot: Robot, values: Mapping[str, np.ndarray]) -> None:
    for k, _ in robot.numbered:
        if not values["lower"][k - 1] < values["upper"][k - 1]:
            raise RobotError(f"robot {robot.name}: joint{k}.lower must be below joint{k}.upper")
        for name in ("speed", "acceleration", "torque"):
            if not values[name][k - 1] > 0:
                raise RobotError(f"robot {robot.name}: the limit joint{k}.{name} must be above zero")


def _listed(which: np.ndarray) -> str:
    if which.all():
        return "every joint"
    return ", ".join(f"joint{k + 1}" for k in np.flatnonzero(which))
