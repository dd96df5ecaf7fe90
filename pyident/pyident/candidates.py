"""What a diagnosis may name: every effect of the catalogue at every joint where it can act."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.effects import CATALOGUE
from flexmodels.robot import Robot, RobotError
from pyident.law_columns import effect_columns, nonlinear_grid
from pyident.spectra import Equations


@dataclass(frozen=True)
class Candidate:
    """An effect at a joint (from 1), its nonlinear parameters fixed.

    log   number of the only log in which it acts (a payload is carried in some logs); None: in all of them
    """

    effect: str
    joint: int
    values: tuple[tuple[str, float], ...] = ()
    log: int | None = None

    @property
    def family(self) -> tuple[str, int, int | None]:
        """The candidate without its nonlinear values."""
        return self.effect, self.joint, self.log

    def at(self, values: Mapping[str, float]) -> "Candidate":
        return Candidate(self.effect, self.joint, tuple(values.items()), self.log)


def candidates(robot: Robot, logs: Sequence[Equations]) -> list[Candidate]:
    """Every effect that the robot does not have yet, over the grid of its nonlinear parameters."""
    found = []
    for joint, present in robot.numbered:
        for effect in CATALOGUE.values():
            if effect.base or effect.name in present.values:
                continue
            try:
                grid = nonlinear_grid(robot, joint, effect.name, logs[0].part.motion)
            except RobotError:
                continue  # the law cannot act at this joint
            scopes = range(len(logs)) if effect.body else (None,)
            found += [
                Candidate(effect.name, joint, tuple(values.items()), log) for log in scopes for values in grid
            ]
    return found


def bounds(robot: Robot, candidate: Candidate) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper (K,) of the linear parameters."""
    law = (
        robot.with_effect(candidate.joint, candidate.effect).joints[candidate.joint - 1].law(candidate.effect)
    )
    return np.array([p.lower for p in law.linear]), np.array([p.upper for p in law.linear])


def columns(
    robot: Robot, candidate: Candidate, logs: Sequence[Equations], levels: Sequence[np.ndarray]
) -> list[dict[int, np.ndarray]]:
    """Per log: row -> (E, K) columns of the linear parameters over the floor. `robot` is fitted."""
    out = []
    for i, (log, level) in enumerate(zip(logs, levels, strict=True)):
        if candidate.log in (None, i):
            out.append(_columns(robot, candidate, log, level))
        else:
            out.append({0: np.zeros((log.y.shape[1], len(bounds(robot, candidate)[0])))})
    return out


def _columns(robot: Robot, candidate: Candidate, log: Equations, level: np.ndarray) -> dict[int, np.ndarray]:
    slopes = effect_columns(robot, candidate.joint, candidate.effect, log.part.motion, dict(candidate.values))
    rows = sorted({row for by_row in slopes.values() for row in by_row})
    nothing = np.zeros(len(log.part.target))
    out = {}
    for row in rows:
        X = np.column_stack([by_row.get(row, nothing) for by_row in slopes.values()])
        out[row] = log.band.transform(X * log.part.use[:, row, None]) / level[row][:, None]
    return out


def nonlinear_range(
    robot: Robot, candidate: Candidate, listed: Sequence[Candidate]
) -> tuple[list[str], np.ndarray, np.ndarray, np.ndarray]:
    """Names, values, lower and upper ends of the nonlinear parameters: the ends are the grid's neighbours."""
    joint = robot.with_effect(candidate.joint, candidate.effect).joints[candidate.joint - 1]
    grid = np.array([[v for _, v in c.values] for c in listed if c.family == candidate.family])
    start, low, high = [], [], []
    for j, parameter in enumerate(joint.law(candidate.effect).nonlinear):
        value = candidate.values[j][1]
        others = np.unique(np.append(grid[:, j], value))
        at = int(np.searchsorted(others, value))
        reach = max(float(np.diff(others).max()), 1e-3 * abs(value)) if len(others) > 1 else abs(value) / 2
        below = others[at - 1] if at > 0 else (value / 1.5 if value > 0 else value - reach)
        above = others[at + 1] if at + 1 < len(others) else (1.5 * value if value > 0 else value + reach)
        start.append(value)
        low.append(max(below, parameter.lower))
        high.append(min(above, parameter.upper))
    return [name for name, _ in candidate.values], np.array(start), np.array(low), np.array(high)
