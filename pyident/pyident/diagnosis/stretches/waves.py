"""What every law would take of every equation, over time: the answers to "would this explain that bump?".

The fit of the model's own columns and one law more is that of the diagnosis (`base.projection`), each
equation over the floor of a comparison's replicas. None of them is made lighter: with the law that is missing
they agree, and made lighter, a strong law's own equation would hardly count in its fit. What the law takes of
an equation is then followed over time: X c less what the model's own parameters could imitate of it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import joint_name
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import (
    Candidate,
    Family,
    bounds,
    columns,
    every_law,
    law_of,
    motion_for,
    slopes,
)
from pyident.diagnosis.base.nonlinear_values import proper
from pyident.diagnosis.base.projection import Base, Gain, gain, solve_base, taken_over
from pyident.diagnosis.base.residual_over_floor import whitened
from pyident.estimation.estimator import weighted
from pyident.estimation.identify import identified
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.regression.regressor import regressor_blocks
from pyident.regression.spectrum import Equations, Floor, equations
from pyident.rules.rules import RULES

Progress = Callable[[float], None]
_CANDIDATES = 0.8  # share of the work


@dataclass(frozen=True)
class LawWave:
    """A law at a joint at its best values, and what it takes of the equations on which it acts.

    values, units   of its parameters, by name
    experiment      the motion that separates it from its confounders
    taken           (log, coordinate) -> (N,) [N m or N]
    """

    effect: str
    joint: str
    values: Mapping[str, float]
    units: Mapping[str, str]
    experiment: str
    taken: Mapping[tuple[str, str], np.ndarray]

    @property
    def name(self) -> str:
        return f"{self.effect} at {self.joint}"


@dataclass(frozen=True)
class Waves:
    """Of a robot along logs.

    refitted   (log, coordinate) -> (N,) residual under new values of the robot's own laws
    """

    laws: tuple[LawWave, ...]
    refitted: Mapping[tuple[str, str], np.ndarray]


def waves(
    robot: Robot,
    logs: Sequence[Log],
    level: Floor,
    unseen: Sequence[Log] = (),
    progress: Progress = lambda _: None,
) -> Waves:
    """Every law of the catalogue at every joint; the robot's own parameters are not used.

    level    of the equations, from replicas
    unseen   logs along which the laws are followed, too, but to which nothing is fitted
    Raises LogError.
    """
    found = weighted(Problem(robot, tuple(condition(log, robot) for log in logs)))
    fitted = identified(robot, found.reduced, found.solution).robot
    data = whitened(fitted, logs, [level] * len(logs))
    base = solve_base(data)
    laws = _fitted_laws(fitted, data, base, level, progress)
    names = [log.source for log in (*logs, *unseen)]
    data = data + equations(
        fitted, [condition(log, fitted) for log in unseen], [log.period for log in unseen]
    )
    rows = range(len(fitted.coordinates))
    sets = {c: [base.p, *(law.imitation for law in laws if c in law.rows)] for c in rows}
    forces = [_forces(fitted, e.part, sets) for e in data]
    refitted = {
        (name, row): e.part.used(c, e.part.target[:, c] - force[c][:, 0]).astype(np.float32)
        for name, e, force in zip(names, data, forces, strict=True)
        for c, row in enumerate(fitted.coordinates)
    }
    taken: list[dict[tuple[str, str], np.ndarray]] = [{} for _ in laws]
    for number, (name, e, force) in enumerate(zip(names, data, forces, strict=True)):
        for c in rows:
            acting = [i for i, law in enumerate(laws) if c in law.rows]
            for place, i in enumerate(acting, start=1):
                if laws[i].candidate.log not in (None, number):
                    continue  # a body that is carried in another log
                wave = e.part.used(c, _force(fitted, laws[i], e, c) - force[c][:, place])
                taken[i][name, fitted.coordinates[c]] = wave.astype(np.float32)
    progress(1.0)
    return Waves(tuple(_named(fitted, law, own) for law, own in zip(laws, taken, strict=True)), refitted)


@dataclass(frozen=True)
class _Law:
    """A family at its best: what it explains, the parameters (P,) that imitate it, the rows it acts on."""

    candidate: Candidate
    gain: Gain
    imitation: np.ndarray
    rows: frozenset[int]


def _fitted_laws(
    robot: Robot, data: Sequence[Equations], base: Base, level: Floor, progress: Progress
) -> list[_Law]:
    """The best of every family that explains anything."""
    levels = [level.at(e.band) for e in data]
    listed = [c for c in every_law(robot, data, base.p, RULES.periodic) if not c.speeds]
    own = dict(zip(robot.linear_parameters, base.p.tolist(), strict=True))
    period = max(e.band.period for e in data)
    best: dict[Family, _Law] = {}
    for i, candidate in enumerate(listed):
        X = columns(robot, candidate, data, levels)
        explained = gain(base, X, *bounds(robot, candidate))
        known = best.get(candidate.family)
        better = explained.energy > (known.gain.energy if known else 0.0)
        if better and proper(robot, candidate, explained.coefficients.tolist(), own, period):
            imitation = taken_over(base, X) @ explained.coefficients
            rows = frozenset(row for by_row in X for row in by_row)
            best[candidate.family] = _Law(candidate, explained, imitation, rows)
        progress(_CANDIDATES * (i + 1) / len(listed))
    return list(best.values())


def _forces(
    robot: Robot, part: Conditioned, sets: Mapping[int, Sequence[np.ndarray]]
) -> dict[int, np.ndarray]:
    """Row -> (N, K): forces of K sets (P,) of the robot's own parameters."""
    stacked = {c: np.column_stack(listed) for c, listed in sets.items()}
    pieces: dict[int, list[np.ndarray]] = {c: [] for c in sets}
    for _, Phi in regressor_blocks(robot, part.motion):
        for c, p in stacked.items():
            pieces[c].append(Phi[:, c] @ p)
    return {c: np.concatenate(listed) for c, listed in pieces.items()}


def _force(robot: Robot, law: _Law, log: Equations, row: int) -> np.ndarray:
    """(N,) of the law on one row."""
    c = law.candidate
    unit_forces = slopes(robot, c, motion_for(robot, c, log.part.motion))
    force = np.zeros(len(log.part.target))
    for by_row, coefficient in zip(unit_forces.values(), law.gain.coefficients, strict=True):
        force += coefficient * by_row.get(row, 0.0)
    return force


def _named(robot: Robot, fitted: _Law, taken: Mapping[tuple[str, str], np.ndarray]) -> LawWave:
    c = fitted.candidate
    law = law_of(robot, c)
    values = dict(zip((p.name for p in law.linear), fitted.gain.coefficients.tolist(), strict=True))
    values |= dict(c.values)
    units = robot.with_effect(c.joint, c.effect).units
    named = {n: units[parameter_name(c.joint, c.effect, n)] for n in values}
    return LawWave(c.effect, joint_name(c.joint), values, named, law.experiment, taken)
