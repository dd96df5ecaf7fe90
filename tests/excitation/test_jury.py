"""Who rehearses a plan is asked in turns, and says what would be broken."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
import pytest
from planned_joint import limited

from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.excitation.capsules import geometry_of
from pyident.excitation.limits import limits_of
from pyident.excitation.rehearsals.jury import Jury
from pyident.excitation.rehearsals.rehearsal import Rehearsal, others_like
from pyident.logs.log import Log

TIME = np.arange(0, 3.001, 0.01)
ANGLE = 0.5 * np.sin(np.pi * TIME / 3) ** 4
PLAN = Experiment(TIME, ANGLE[:, None], np.zeros((len(TIME), 1)))
ALLOWED = 60.0  # N m
Values = tuple[float, ...]


def values(robot: Robot) -> Values:
    return tuple(robot.parameters.values())


@dataclass(frozen=True)
class Played(Rehearsal):
    """Runs along the plan with written torques; of others by their parameters."""

    own: float
    largest: dict[Values, float]
    asked: list[int] = field(default_factory=list)

    def log(self, plan):
        return Log(_run(self.own))

    def others(self, plan, robots):
        self.asked.append(len(robots))
        return [_run(self.largest.get(values(robot), 20.0)) for robot in robots]


def _run(torque: float) -> pd.DataFrame:
    return pd.DataFrame(
        {"time": TIME, "joint1.e": ANGLE, "joint1.r": ANGLE, "joint1.tau": torque * ANGLE / 0.5}
    )


def jury(own=20.0, largest=None) -> tuple[Jury, Played]:
    robot = limited()
    played = Played(robot, None, own, largest or {})
    return Jury(robot, limits_of(robot), geometry_of(robot, None, None), [played], 0.25), played


def others() -> list[Values]:
    return [values(robot) for robot in jury()[0].others]


def test_a_plan_that_all_keep_has_nothing_in_its_way():
    judges, played = jury()
    assert judges.broken(PLAN) == ""
    assert sum(played.asked) == len(judges.others)


def test_the_robot_itself_is_asked_first():
    judges, played = jury(own=61.0)
    assert judges.broken(PLAN) == "the torque of joint1"
    assert not played.asked


def test_who_broke_a_limit_is_asked_first_the_next_time():
    odd = others()[30]
    judges, played = jury(largest={odd: 1.01 * ALLOWED})
    assert judges.broken(PLAN) == "the torque of joint1"
    turns = len(played.asked)
    assert turns > 1
    assert values(judges.others[0]) == odd
    assert judges.broken(PLAN) == "the torque of joint1"
    assert len(played.asked) == turns + 1


def test_a_limit_that_one_of_thousands_would_break_is_too_near():
    """Torques scatter by 5 N m about 45: three deviations from what is allowed."""
    scattered = {value: 45.0 + 5.0 * (-1) ** i for i, value in enumerate(others())}
    assert jury(largest=scattered)[0].broken(PLAN) == "the torque of joint1"
    closer = {value: 45.0 + 3.0 * (-1) ** i for i, value in enumerate(others())}
    assert jury(largest=closer)[0].broken(PLAN) == ""


def test_a_robot_that_cannot_be_simulated_may_not_run_it():
    class Lost(Played):
        def others(self, plan, robots):
            raise SimulationError("no step is small enough")

    judges, _ = jury()
    judges.rehearsals = [Lost(limited(), None, 20.0, {})]
    assert judges.broken(PLAN) == "the simulation's step"


@pytest.mark.parametrize("spread", [0.25, 0.1])
def test_the_others_are_off_by_the_spread(spread):
    robot = limited()
    for other in others_like(robot, 20, spread=spread):
        ratio = other.parameters["joint1.viscous"] / robot.parameters["joint1.viscous"]
        assert 0.4 * spread - 1e-12 <= abs(ratio - 1) <= spread + 1e-12
