"""What a search for a separation may choose from, and that it takes what is worth most in simulation."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from planned_joint import limited

from flexmodels.experiment import Experiment
from pyident.excitation.capsules import geometry_of
from pyident.excitation.design import informative, measure
from pyident.excitation.drawing import Drawing
from pyident.excitation.limits import limits_of
from pyident.excitation.rehearsals.rehearsal import rehearsal
from pyident.excitation.search import Budget
from pyident.excitation.separation.search import Separation
from pyident.excitation.separation.tuned import Tuned
from pyident.excitation.task import Task
from pyident.excitation.variants import at_rest, variants


def task_of(robot=None) -> Task:
    robot = robot or limited()
    return Task(robot, limits_of(robot), geometry_of(robot, floor=None), {"joint1.e": 1e-5}, 3.0, 250.0)


@dataclass
class Wanted:
    """A contest that is decided by the largest torque of the multisine."""

    torque: float
    rehearsals: tuple[Any, ...] = ()
    asked: list[float] = field(default_factory=list)

    def sigmas(self, plan: Experiment, seeds) -> float:
        self.asked.append(float(np.abs(plan.feedforward).max()))
        return -abs(self.asked[-1] - self.torque)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_the_motion_that_is_worth_most_is_taken(share):
    task = task_of()
    drawing, torque = Drawing(task), share * float(np.abs(task.multisine).max())
    with rehearsal(task.robot) as own:
        level = measure(task, drawing, own)
        contest = Wanted(torque)
        search: Any = Separation(task, contest, informative(task, drawing, level), level)  # pyright: ignore
        found = search.designed(own, Budget(40))
    best = min(contest.asked, key=lambda peak: abs(peak - torque))
    assert abs(best - torque) < 1e-9
    assert np.abs(found.offer.plan.feedforward).max() == pytest.approx(best, abs=1e-9)
    assert np.abs(found.plan.feedforward).max() == pytest.approx(found.scale * best, abs=1e-9)


def test_the_variants_are_members_of_the_tuned_experiment(four_link):
    """With limits that allow them they follow the same references."""
    limits = limits_of(four_link)
    task = Task(four_link, limits, geometry_of(four_link, floor=None), {}, 4.0, 250.0)
    tuned = Tuned.of(task, Drawing(task))
    assert tuned is not None
    library = [at_rest(plan).reference for plan in variants(four_link, duration=4.0).values()]
    assert len(tuned.starts) == len(library)
    for z, wanted in zip(tuned.starts, library, strict=True):
        plan = tuned.plan(z)
        assert plan is not None
        assert plan.reference == pytest.approx(wanted, abs=2e-3)


def test_every_tuned_motion_keeps_the_limits_and_rests_at_its_ends():
    task = task_of()
    tuned = Tuned.of(task, Drawing(task))
    assert tuned is not None
    rng = np.random.default_rng(1)
    for _ in range(20):
        plan = tuned.plan(rng.normal(1, 2, 3))
        assert plan is not None
        speed = np.gradient(plan.reference[:, 0], plan.time)
        assert np.abs(speed).max() <= task.limits.speed[0]
        assert plan.reference.max() <= task.limits.upper[0]
        assert plan.reference.min() >= task.limits.lower[0]
        assert np.abs(speed[[0, -1]]).max() <= 1e-2 * np.abs(speed).max()
        assert np.abs(plan.feedforward).max() <= 0.4 * task.limits.torque[0] + 1e-9


def test_a_motion_at_rest_goes_the_same_way():
    time = np.arange(1001) / 250
    plan = at_rest(Experiment(time, np.column_stack([np.sin(time), 1 - np.cos(time)]), np.ones((1001, 2))))
    circle = np.hypot(plan.reference[:, 0], plan.reference[:, 1] - 1)
    assert circle == pytest.approx(np.ones(1001), abs=1e-6)
    speed = np.gradient(plan.reference, time, axis=0)
    assert np.abs(speed[[0, -1]]).max() < 1e-3
    assert np.abs(speed).max() < 1.001
    assert np.abs(plan.feedforward[[0, -1]]).max() == 0
