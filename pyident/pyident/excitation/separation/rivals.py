"""Two explanations of the same robot, and how far apart they are along a reference that is followed exactly.

The distance is what is left of one rival's forces after the other has been refitted to them: all its linear
parameters freely, its nonlinear ones over their grid. It is counted in standard deviations of the sensors'
noise, so that its square is the expected fall of the weighted sum of squares.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.joint import parameter_name
from flexmodels.robot import Robot, RobotError
from pyident.conditioning.weak_form import condition
from pyident.excitation.criterion import Along
from pyident.excitation.separation.sizes import values_of
from pyident.logs.log import Log
from pyident.regression.candidate_columns import nonlinear_grid

_SUSPECT = re.compile(r"([a-z_]+)@([0-9]{1,4})(?:=(.+))?")
_LARGEST = 1e12  # of any effect, in SI units
_CUT = 1e-10  # of the largest eigenvalue of a scaled Gram matrix: below is arithmetic


@dataclass(frozen=True)
class Suspect:
    """An effect at a joint (from 1).

    size     of the parameter it is sized by, None where nothing is known
    values   parameter and value, of others that are known
    """

    effect: str
    joint: int
    size: float | None = None
    values: tuple[tuple[str, float], ...] = ()

    @property
    def name(self) -> str:
        return f"{self.effect}@{self.joint}"


def suspect(text: str) -> Suspect:
    """`stribeck@2`, `backlash@3=1e-4` or `stribeck@2=level=3,velocity=0.1`. Raises RobotError."""
    parts = _SUSPECT.fullmatch(text.strip())
    try:
        if parts is None:
            raise ValueError
        pairs = [part.rpartition("=") for part in parts[3].split(",")] if parts[3] else []
        given = {name.strip(): float(number) for name, _, number in pairs}
        if len(given) < len(pairs):
            raise ValueError
    except ValueError:
        raise RobotError(
            f"{text!r} is not EFFECT@JOINT, such as stribeck@2, with =SIZE or =PARAMETER=VALUE,... after it"
        ) from None
    size = given.pop("", None)
    if size == 0 or not all(abs(x) < _LARGEST for x in (size or 1.0, *given.values())):
        raise RobotError(f"{text!r}: a size is not zero, and every value is below {_LARGEST:g} in SI units")
    return Suspect(parts[1], int(parts[2]), size, tuple(given.items()))


def taken_out(robot: Robot, who: Suspect) -> tuple[Robot, Suspect]:
    """The robot without the suspect's law, and the suspect with the values that the robot had for it.

    Values that are given go before the robot's. A law that every robot file has stays, and so does a robot
    without the law: both are returned as they are.
    """
    joint = robot.joints[who.joint - 1] if 1 <= who.joint <= len(robot.joints) else None
    if joint is None or who.effect not in joint.values or joint.law(who.effect).base:
        return robot, who
    law, values = joint.law(who.effect), joint.values[who.effect]
    found = values if any(values[p.name] for p in law.linear) else {}  # without a size it is as if unknown
    known = replace(who, values=tuple({**found, **dict(who.values)}.items()))
    return robot.without_effect(who.effect, who.joint), known


def having(robot: Robot, who: Suspect, log: Log) -> Robot:
    """The robot with the effect; sizes that are not known are small beside what acts along a log.

    log   of the robot without the effect, by which the sizes are taken
    Raises RobotError where the law cannot act, or acts already.
    """
    has = 1 <= who.joint <= len(robot.joints) and who.effect in robot.joints[who.joint - 1].values
    if has:
        raise RobotError(f"robot {robot.name} has {who.name} already; give a model without it")
    extended = robot.with_effect(who.joint, who.effect)
    law = extended.joints[who.joint - 1].law(who.effect)
    known = dict(who.values) if who.size is None else dict(who.values) | {law.size.name: who.size}
    for name in set(known) - {p.name for p in law.parameters}:
        listed = ", ".join(p.name for p in law.parameters)
        raise RobotError(f"{who.effect} has no parameter {name!r}; they are {listed}")
    sizes = values_of(robot, law, who.joint, condition(log, robot), known)
    return extended.with_parameters({parameter_name(who.joint, who.effect, n): v for n, v in sizes.items()})


@dataclass(frozen=True)
class Rivals:
    """The robot without either effect, the two suspects with their robots; a suspect None has no effect."""

    base: Robot
    suspects: tuple[Suspect | None, Suspect | None]
    robots: tuple[Robot, Robot]

    def score(self, grids: Sequence[Sequence[Mapping[str, float]]]) -> "Score":
        """Of candidates along their references. grids: nonlinear values of each suspect to refit over."""
        return Score(self, grids)

    def grids(self, log: Log) -> list[list[dict[str, float]]]:
        """Nonlinear values of each suspect: those of the grid and its own."""
        part = condition(log, self.base)
        out = []
        for who, robot in zip(self.suspects, self.robots, strict=True):
            if who is None:
                out.append([{}])
                continue
            values = nonlinear_grid(self.base, who.joint, who.effect, [part.motion])
            out.append([*values, law_values(robot, who)[1]])
        return out


@dataclass(frozen=True)
class Score:
    """Distance of the closer of the two ways round, of what a candidate motion would tell."""

    rivals: Rivals
    grids: Sequence[Sequence[Mapping[str, float]]]

    def __call__(self, found: Along) -> float:
        sides = []
        for own, other in ((0, 1), (1, 0)):
            who, robot = self.rivals.suspects[own], self.rivals.robots[own]
            if who is None:
                continue
            linear, nonlinear = law_values(robot, who)
            X = found.force(self.rivals.base, who.joint, who.effect, nonlinear)
            y = X @ np.array(list(linear.values()))
            sides.append(self._left(found, y, other))
        return float(np.sqrt(min(sides)))

    def _left(self, found: Along, y: np.ndarray, other: int) -> float:
        """Least energy that the other rival leaves of forces y (n, E)."""
        rival, base = self.rivals.suspects[other], found.A.reshape(-1, found.A.shape[2])
        if rival is None:
            return remaining(base, y.ravel())
        left = []
        for values in self.grids[other]:
            X = found.force(self.rivals.base, rival.joint, rival.effect, values)
            left.append(remaining(np.hstack([base, X.reshape(len(base), -1)]), y.ravel()))
        return min(left)


def remaining(A: np.ndarray, y: np.ndarray) -> float:
    """|y − A x|² of the best x for A (N, K), y (N,), without ever being negative."""
    size = np.linalg.norm(A, axis=0)
    A = A[:, size > 0] / size[size > 0]
    w, V = np.linalg.eigh(A.T @ A)
    kept = w > _CUT * w[-1]
    x = V[:, kept] @ ((V[:, kept].T @ (A.T @ y)) / w[kept])
    rest = y - A @ x
    return float(rest @ rest)


def law_values(robot: Robot, who: Suspect) -> tuple[dict[str, float], dict[str, float]]:
    """Linear and nonlinear values of the effect."""
    law, values = robot.joints[who.joint - 1].law(who.effect), robot.joints[who.joint - 1].values[who.effect]
    return {p.name: values[p.name] for p in law.linear}, {p.name: values[p.name] for p in law.nonlinear}
