"""What a diagnosis may name: every effect of the catalogue at every joint; and errors of the description."""

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice

import numpy as np

from flexmodels.effects import signals
from flexmodels.effects.effect import Effect, Parameter
from flexmodels.joint import parameter_name, unit_at
from flexmodels.robot import Robot, RobotError
from pyident.conditioning.motion import Motion
from pyident.conditioning.samples import Conditioned
from pyident.diagnosis.base.order_peaks import Orders, between, order_peaks
from pyident.regression.candidate_columns import effect_columns, nonlinear_grid
from pyident.regression.descriptions import (
    DESCRIPTIONS,
    DRIVE,
    describes,
    description_column,
    description_names,
)
from pyident.regression.loads.swinging_drive import NO_SPRINGS, Springs, as_values, from_values, up_to
from pyident.regression.recent import Recent
from pyident.regression.regressor import generalised_forces
from pyident.regression.spectrum import Band, Equations
from pyident.rules.periodic import PeriodicRules

_as_they_act: Recent[dict[int, np.ndarray]] = Recent(512)
_at_speeds: Recent[dict[int, np.ndarray]] = Recent(32)  # wide ones
_with_torques: Recent[Motion] = Recent(16)
_TOGETHER = 16  # candidates whose columns are transformed at once

Family = tuple[str, int, int | None, bool]


@dataclass(frozen=True)
class Candidate:
    """An effect or a wrong description at a joint (from 1), its nonlinear parameters fixed.

    log      number of the only log in which it acts (a payload is carried in some logs); None: in all of them
    speeds   of its joint [rad/s], at each of which it has parameters of its own (see `order_peaks`); none: it
             has the same at all speeds
    """

    effect: str
    joint: int
    values: tuple[tuple[str, float], ...] = ()
    log: int | None = None
    speeds: tuple[float, ...] = ()

    @property
    def family(self) -> Family:
        """The candidate without its nonlinear values; and whether its parameters are those of its speed."""
        return self.effect, self.joint, self.log, bool(self.speeds)

    def at(self, values: Mapping[str, float]) -> "Candidate":
        return replace(self, values=tuple(values.items()))

    @property
    def nonlinear(self) -> tuple[tuple[str, float], ...]:
        """The values that were found as a law's parameters are; a description has none."""
        return () if self.describes else self.values

    @property
    def describes(self) -> bool:
        """Whether it is an error of the robot's description, not a law."""
        return describes(self.effect)


def candidates(
    robot: Robot, logs: Sequence[Equations], orders: Mapping[int, Orders] | None = None
) -> list[Candidate]:
    """Every effect that the robot does not have yet, over the grid of its nonlinear parameters.

    orders   of every joint at which periodic laws are tried besides those of their grid
    """
    found = []
    motions = [log.part.motion for log in logs]
    for joint, present in robot.numbered:
        for effect in robot.catalogue.values():
            if effect.name in present.values:
                continue
            if effect.excess_over and effect.excess_over not in present.values:
                continue
            try:
                grid = nonlinear_grid(robot, joint, effect.name, motions)
            except RobotError:
                continue  # the law cannot act at this joint
            if orders:
                grid = orders[joint].beside(grid, effect)
            scopes = range(len(logs)) if effect.body else (None,)
            found += [
                Candidate(effect.name, joint, tuple(values.items()), log) for log in scopes for values in grid
            ]
            wave = effect.order_of_torque
            if orders and wave and effect.nonlinear == (wave,) and robot.controller is None:
                at, speeds = orders[joint].answered, orders[joint].speeds
                found += [Candidate(effect.name, joint, ((wave.name, n),), None, speeds) for n in at]
    return found


def width(robot: Robot, candidate: Candidate) -> int:
    """Number of its linear parameters."""
    return len(bounds(robot, candidate)[0])


def every_law(
    robot: Robot, logs: Sequence[Equations], p: np.ndarray, rules: PeriodicRules
) -> list[Candidate]:
    """`candidates`, and periodic laws at the orders that stand out of what p (P,) leaves."""
    joints = range(1, len(robot.joints) + 1)
    return candidates(robot, logs, order_peaks(robot, logs, p, rules, joints))


def described(robot: Robot, still: Container[int] = (), bends: Springs = NO_SPRINGS) -> list[Candidate]:
    """Every quantity of the robot's description that may be wrong.

    still   joints, from 1, that stand in one place: masses make up for what is wrong with those
    bends   springs about which drives are described, each beside those before it; none: as slopes
    """
    return [
        drive(joint, up_to(bends, joint)) if name == DRIVE else Candidate(name, joint)
        for joint, _ in robot.numbered
        for name in description_names(robot, joint)
        if joint not in still or DESCRIPTIONS[name].whole
    ]


def drive(joint: int, about: Springs = NO_SPRINGS) -> Candidate:
    """That a joint's drive bends, described about its spring, the last, beside others; none: as a slope."""
    return Candidate(DRIVE, joint, as_values(about))


def law_of(robot: Robot, candidate: Candidate) -> Effect:
    """The law as it would act at its joint; of a description one without forces that corrects it."""
    if candidate.describes:
        d = DESCRIPTIONS[candidate.effect]
        unit = unit_at(robot.joints[candidate.joint - 1], d.unit) if d.name == DRIVE else d.unit
        parameter = Parameter("correction", unit, lower=0.0 if d.positive else -d.largest, upper=d.largest)
        measure = f"a measurement of {d.words}, or slow motion through poses far apart"
        return Effect(d.name, d.words, {}, (parameter,), citation="", experiment=measure)
    return robot.joints[candidate.joint - 1].law(candidate.effect)


def with_law(robot: Robot, candidate: Candidate) -> Robot:
    """The robot with the law, its nonlinear parameters at the candidate's values."""
    values = {parameter_name(candidate.joint, candidate.effect, name): v for name, v in candidate.values}
    return robot.with_effect(candidate.joint, candidate.effect).with_parameters(values)


def units_of(robot: Robot, candidate: Candidate) -> dict[str, str]:
    """Parameter -> unit, at its joint."""
    law = law_of(robot, candidate)
    if candidate.describes:
        return {p.name: p.unit for p in law.parameters}
    units = robot.with_effect(candidate.joint, candidate.effect).units
    return {p.name: units[parameter_name(candidate.joint, candidate.effect, p.name)] for p in law.parameters}


def bounds(robot: Robot, candidate: Candidate) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper (K,) of the linear parameters."""
    linear = law_of(robot, candidate).linear * max(len(candidate.speeds), 1)
    return np.array([p.lower for p in linear]), np.array([p.upper for p in linear])


def bounds_of(robot: Robot, listed: Sequence[Candidate]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper (K,) of the linear parameters of several, one after the other."""
    lower, upper = zip(*(bounds(robot, c) for c in listed), strict=True)
    return np.concatenate(lower), np.concatenate(upper)


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
            out.append(_columns(robot, candidate, log, level, None if acting is None else acting[i]))
        else:
            out.append({0: np.zeros((log.y.shape[1], len(bounds(robot, candidate)[0])))})
    return out


def columns_of(
    robot: Robot, listed: Sequence[Candidate], logs: Sequence[Equations], levels: Sequence[np.ndarray]
) -> list[list[dict[int, np.ndarray]]]:
    """`columns` of each of many candidates, per log: equation -> (bins, K); they are transformed together."""
    found = [columns(robot, c, logs, levels) if c.describes else [] for c in listed]
    laws = [i for i, c in enumerate(listed) if not c.describes]
    for number, (log, level) in enumerate(zip(logs, levels, strict=True)):
        acting = [i for i in laws if listed[i].log in (None, number)]
        for i in laws:
            found[i].append({})
            if i not in acting:
                found[i][-1][0] = np.zeros((log.y.shape[1], len(bounds(robot, listed[i])[0])))
        raw = (torques_per_unit(robot, listed[i], log.part) for i in acting)
        for i, by_row in zip(acting, _transformed_together(raw, log), strict=True):
            found[i][-1].update({row: X / level[row][:, None] for row, X in by_row.items()})
    return found


def motion_for(robot: Robot, candidate: Candidate, motion: Motion) -> Motion:
    """The log's motion as a law is evaluated along it.

    A measured torque holds the friction that a law would explain, and noise that would explain itself. So a
    law of the motor's torque gets that of the model where no controller says which torque was commanded.
    """
    if candidate.describes or robot.controller is not None:
        return motion
    reads_torque = signals.tau in robot.catalogue[candidate.effect].symbols
    return with_model_torque(robot, motion) if reads_torque else motion


def with_model_torque(robot: Robot, motion: Motion) -> Motion:
    """The motion with the torques that a fitted model needs; where none is told, the robot's own."""

    def made() -> Motion:
        tau = needed_torque(robot, motion) if motion.needed is None else motion.needed
        return replace(motion, tau=tau, tau_before=None if motion.tau_before is None else tau)

    return _with_torques.of((robot, motion), made)


def needed_torque(robot: Robot, motion: Motion) -> np.ndarray:
    """(N, joints) torques that the robot's own parameters need along a motion."""
    p = np.array(list(robot.linear_parameters.values()))
    return generalised_forces(robot, motion, p)[:, : len(robot.joints)]


def slopes(robot: Robot, candidate: Candidate, motion: Motion) -> dict[str, dict[int, np.ndarray]]:
    """Linear parameter -> row -> (N,), the torques that one unit of it makes along a motion."""
    if candidate.describes:
        about = from_values(candidate.values)
        return {"correction": description_column(robot, candidate.joint, candidate.effect, motion, about)}
    return effect_columns(robot, candidate.joint, candidate.effect, motion, dict(candidate.values))


def _columns(
    robot: Robot, candidate: Candidate, log: Equations, level: np.ndarray, acting: np.ndarray | None
) -> dict[int, np.ndarray]:
    if acting is None:
        whole = np.ones(len(log.part.target))
        make = partial(_transformed, robot, candidate, log.part, log.band, whole)
        kept = _at_speeds if candidate.speeds else _as_they_act
        raw = kept.of((robot, log.part), make, candidate)
    else:
        raw = _transformed(robot, candidate, log.part, log.band, acting)
    return {row: X / level[row][:, None] for row, X in raw.items()}


def _transformed(
    robot: Robot, candidate: Candidate, part: Conditioned, band: Band, factor: np.ndarray
) -> dict[int, np.ndarray]:
    """Row -> (E, K)."""
    raw = torques_per_unit(robot, candidate, part)
    return {row: band.transform(part.used(row, X * factor).T) for row, X in raw.items()}


def torques_per_unit(robot: Robot, candidate: Candidate, part: Conditioned) -> dict[int, np.ndarray]:
    """Row -> (K, N), the torques per unit of the linear parameters."""
    of = slopes(robot, candidate, motion_for(robot, candidate, part.motion))
    rows = sorted({row for by_row in of.values() for row in by_row})
    nothing = np.zeros(len(part.target))
    raw = {row: np.array([by_row.get(row, nothing) for by_row in of.values()]) for row in rows}
    if not candidate.speeds:
        return raw
    hats = between(candidate.speeds, part.motion.dq[:, candidate.joint - 1])
    return {row: np.concatenate([x * hats for x in X]) for row, X in raw.items()}


def _transformed_together(
    raw: Iterable[dict[int, np.ndarray]], log: Equations
) -> Iterator[dict[int, np.ndarray]]:
    """Of each candidate's torques row -> (E, K); as many at a time as stay in a core's cache."""
    every = iter(raw)
    while group := list(islice(every, _TOGETHER)):
        out: list[dict[int, np.ndarray]] = [{} for _ in group]
        for row in sorted({row for by_row in group for row in by_row}):
            acting = [i for i, by_row in enumerate(group) if row in by_row]
            X = log.part.used(row, np.concatenate([group[i][row] for i in acting]))
            ends = np.cumsum([len(group[i][row]) for i in acting])[:-1]
            parts = np.split(log.band.transform(X.T), ends, axis=1)
            for i, part in zip(acting, parts, strict=True):
                out[i][row] = part
        yield from out
