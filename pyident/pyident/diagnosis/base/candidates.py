"""What a diagnosis may name: every effect of the catalogue at every joint where it can act."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import of_joint
from flexmodels.effects import CATALOGUE
from flexmodels.effects.effect import Effect
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot, RobotError
from pyident.regression.candidate_columns import effect_columns, nonlinear_grid
from pyident.regression.spectrum import Equations


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
    motions = [log.part.motion for log in logs]
    for joint, present in robot.numbered:
        for effect in CATALOGUE.values():
            if effect.base or effect.name in present.values:
                continue
            try:
                grid = nonlinear_grid(robot, joint, effect.name, motions)
            except RobotError:
                continue  # the law cannot act at this joint
            scopes = range(len(logs)) if effect.body else (None,)
            found += [
                Candidate(effect.name, joint, tuple(values.items()), log) for log in scopes for values in grid
            ]
    return found


def law_of(robot: Robot, candidate: Candidate) -> Effect:
    """The law as it would act at its joint."""
    return robot.joints[candidate.joint - 1].law(candidate.effect)


def with_law(robot: Robot, candidate: Candidate) -> Robot:
    """The robot with the law, its nonlinear parameters at the candidate's values."""
    values = {parameter_name(candidate.joint, candidate.effect, name): v for name, v in candidate.values}
    return robot.with_effect(candidate.joint, candidate.effect).with_parameters(values)


def bounds(robot: Robot, candidate: Candidate) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper (K,) of the linear parameters."""
    law = law_of(robot, candidate)
    return np.array([p.lower for p in law.linear]), np.array([p.upper for p in law.linear])


def proper(
    robot: Robot, candidate: Candidate, coefficients: Sequence[float], parameters: Mapping[str, float]
) -> bool:
    """Whether the values found make the effect what its name says, beside the robot's own parameters."""
    law = law_of(robot, candidate)
    if law.proper is None:
        return True
    own = dict(candidate.values) | dict(zip((p.name for p in law.linear), coefficients, strict=True))
    known = {
        symbol: own.get(symbol.name, parameters.get(of_joint(candidate.joint, f"{symbol.name}")))
        for symbol in law.proper.free_symbols
    }
    return bool(law.proper.subs(known))


def columns(
    robot: Robot,
    candidate: Candidate,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    acting: Sequence[np.ndarray] | None = None,
) -> list[dict[int, np.ndarray]]:
    """Per log: row -> (E, K) columns of the linear parameters over the floor. `robot` is fitted.

    acting   per log (N,): factor of the law's force at each sample; none: 1
    """
    out = []
    for i, (log, level) in enumerate(zip(logs, levels, strict=True)):
        if candidate.log in (None, i):
            factor = np.ones(len(log.part.target)) if acting is None else acting[i]
            out.append(_columns(robot, candidate, log, level, factor))
        else:
            out.append({0: np.zeros((log.y.shape[1], len(bounds(robot, candidate)[0])))})
    return out


def _columns(
    robot: Robot, candidate: Candidate, log: Equations, level: np.ndarray, factor: np.ndarray
) -> dict[int, np.ndarray]:
    slopes = effect_columns(robot, candidate.joint, candidate.effect, log.part.motion, dict(candidate.values))
    rows = sorted({row for by_row in slopes.values() for row in by_row})
    nothing = np.zeros(len(log.part.target))
    out = {}
    for row in rows:
        X = np.column_stack([by_row.get(row, nothing) for by_row in slopes.values()])
        out[row] = log.band.transform(X * (factor * log.part.use[:, row])[:, None]) / level[row][:, None]
    return out
