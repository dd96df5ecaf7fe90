"""A robot with one more law at its best values, or with its description corrected."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmodels.coordinate import of_joint
from flexmodels.robot import Robot, RobotError
from pyident.diagnosis.base.candidates import Candidate, bounds, columns
from pyident.diagnosis.base.projection import gain, solve_base
from pyident.diagnosis.base.residual_over_floor import whitened
from pyident.extension.ask import Asked
from pyident.regression.descriptions import (
    DESCRIPTIONS,
    corrected,
    describes,
    place_name,
    value_of,
)
from pyident.regression.spectrum import levels_of

_ROUNDS = 5  # of Gauss and Newton
_SETTLED = 1e-3  # of the correction


@dataclass(frozen=True)
class Correction:
    """What was added to a quantity of the robot file. before, after: the file's text; may be empty.

    No interval: what else the model lacks bends the amount by more than the noise does.
    """

    place: str
    amount: float
    unit: str
    before: str
    after: str

    def json(self) -> dict[str, Any]:
        return {self.place: {"value": self.amount, "unit": self.unit}}


def require_new(robot: Robot, joint: int, effect: str) -> None:
    """Raises RobotError where the effect cannot be added, or stands there already."""
    if describes(effect):
        corrected(robot, joint, effect, 0.0)
        return
    if robot.with_effect(joint, effect).units == robot.units:
        raise RobotError(f"robot {robot.name} has the effect {effect} at joint {joint} already")
    if robot.catalogue[effect].body:
        raise RobotError(
            f"{effect} at joint {joint} is a part of link {robot.last_link} wherever all logs have it, and "
            "cannot be told from it; what one log carries and another does not is found by `pyident payload "
            "MODEL EMPTY LOADED`"
        )


def known_beforehand(robot: Robot, joint: int, effect: str) -> Robot | None:
    """The robot with a law whose parameters are all linear; None where a search must find values first."""
    if describes(effect):
        return None
    wider = robot.with_effect(joint, effect)
    return None if wider.joints[joint - 1].law(effect).nonlinear else wider


def extended_robot(robot: Robot, asked: Asked) -> tuple[Robot, Correction | None]:
    """The robot with the law, its nonlinear values those of the search; or corrected, and by what."""
    c = asked.candidate
    if describes(c.effect):
        correction = _correction(robot, asked)
        return corrected(robot, c.joint, c.effect, correction.amount), correction
    names = {name: of_joint(c.joint, f"{c.effect}.{name}") for name, _ in c.values}
    wider = robot.with_effect(c.joint, c.effect)
    return wider.with_parameters({names[name]: value for name, value in c.values}), None


def _correction(robot: Robot, asked: Asked) -> Correction:
    """By Gauss and Newton: the column is that of the corrected robot, everything else fitted beside it."""
    c, examination = asked.candidate, asked.search.examination
    start, logs = examination.setting.robot, examination.setting.logs
    amount, std = float(asked.found.gain.coefficients[0]), float(asked.found.gain.std[0])
    for _ in range(_ROUNDS):
        here = corrected(start, c.joint, c.effect, amount)
        data = whitened(here, logs, examination.floors)
        base = solve_base(data)
        here = here.with_parameters(dict(zip(here.linear_parameters, base.p.tolist(), strict=True)))
        levels = levels_of(examination.floors, data)
        step = gain(base, columns(here, Candidate(c.effect, c.joint), data, levels), *bounds(here, c))
        change, std = float(step.coefficients[0]), float(step.std[0])
        amount += change
        if abs(change) < _SETTLED * abs(amount):
            break
    if not np.isfinite(std):
        raise RobotError(
            f"{place_name(c.joint, c.effect)} of robot {robot.name}: the model's own parameters imitate it "
            "in these logs, so it cannot be corrected from them"
        )
    before, after = (
        value_of(r, c.joint, c.effect) for r in (robot, corrected(robot, c.joint, c.effect, amount))
    )
    unit = DESCRIPTIONS[c.effect].unit
    return Correction(place_name(c.joint, c.effect), amount, unit, before, after)
