"""Distances of links: against a search over both lines, and in poses where the answer is plain."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import minimize

from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import load_robot
from flexmodels.joint import Joint
from flexmodels.robot import Robot
from pyident.excitation.capsules import between, clearances, geometry_of
from pyident.excitation.design import confined
from pyident.excitation.limits import Limits
from pyident.excitation.task import Task


def brute_force(a, b, c, d) -> float:
    """The least distance by bounded minimisation from a grid of starts."""

    def square(x):
        return float(np.sum((a + x[0] * (b - a) - c - x[1] * (d - c)) ** 2))

    starts = [(s, t) for s in (0.1, 0.5, 0.9) for t in (0.1, 0.5, 0.9)]
    found = [minimize(square, x0, bounds=[(0, 1), (0, 1)], tol=1e-14).fun for x0 in starts]
    return float(np.sqrt(min(found)))


def test_segments_are_as_far_apart_as_a_search_says():
    a, b, c, d = np.random.default_rng(0).uniform(-1, 1, (4, 40, 3))
    d[:10] = c[:10] + 0.7 * (b - a)[:10]  # parallel ones
    d[10:13] = c[10:13]  # points
    expected = [brute_force(*ends) for ends in zip(a, b, c, d, strict=True)]
    assert between(a, b, c, d) == pytest.approx(expected, abs=1e-5)


def pose(*angles: float) -> pd.DataFrame:
    return pd.DataFrame([angles], columns=[f"joint{k}.e" for k in range(1, len(angles) + 1)])


def nearest(frame: pd.DataFrame) -> dict[str, float]:
    found = clearances(geometry_of(load_robot("four_link"), radius=0.06), frame)
    return {c.what: float(c.distance.min()) for c in found}


def test_an_arm_that_folds_back_meets_itself():
    assert min(nearest(pose(0, 0, 0, 0)).values()) > 0
    assert min(nearest(pose(0, 0, 1.5, 0)).values()) > 0
    folded = nearest(pose(0, 0, np.pi, 0))
    assert folded["link 2 and link 4"] < 0


def test_an_arm_that_bends_down_meets_the_floor():
    down = nearest(pose(0, 2.6, 0, 0))  # the tip at 0.42 + 0.985 cos 2.6 = -0.42 m
    assert down["link 4 and the floor"] == pytest.approx(0.42 + 0.985 * np.cos(2.6) - 0.06, abs=1e-9)
    assert down["link 4 and the floor"] < 0


def test_without_gravity_there_is_no_floor():
    shape = geometry_of(replace(load_robot("four_link"), gravity=(0.0, 0.0, 0.0)))
    assert shape.floor is None
    assert any("no gravity" in note for note in shape.notes)


def lying() -> Robot:
    """A hinge in the base's axis x, 0.1 m over it, and two bars of 0.5 m along y, the second hinged alike."""
    robot = load_robot("four_link")
    x, y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    first, second = (
        Joint("revolute", x, y, origin, False, {}) for origin in ((0.0, 0.0, 0.1), (0.0, 0.5, 0.0))
    )
    return replace(robot, joints=(first, second), links=robot.links[:2], tip=(0.0, 0.5, 0.0))


def floors(turns: list[tuple[float, float]], floor: float, begin=(0.0, 0.0)) -> dict[str, float]:
    """What is left of every link's distance to the floor."""
    frame = pd.DataFrame(turns, columns=["joint1.e", "joint2.e"])
    shape = geometry_of(lying(), radius=0.04, floor=floor, begin=np.array(begin))
    near = [c for c in clearances(shape, frame) if c.what.endswith("the floor")]
    return {c.what: float((c.distance - c.least).min()) for c in near}


def test_a_link_that_begins_in_the_floor_may_not_go_deeper_than_it_bends():
    """At 0.08 m the bars begin 0.02 m in the floor; a quarter of the radius, 0.01 m, is left for sagging."""
    shape = geometry_of(lying(), radius=0.04, floor=0.08)
    assert [link.least for link in shape.grounded] == pytest.approx([-0.03, -0.03])
    assert shape.sunk == ()
    assert any(note.startswith("link 1 and link 2 reach below the floor where") for note in shape.notes)
    left = floors([(0.0, 0.0)], 0.08)
    assert left == pytest.approx({"link 1 and the floor": 0.01, "link 2 and the floor": 0.01})
    dipped = floors([(0.0, 0.0), (0.0, -0.1)], 0.08)
    assert dipped["link 1 and the floor"] == pytest.approx(0.01)
    assert dipped["link 2 and the floor"] == pytest.approx(0.01 - 0.5 * np.sin(0.1))


def test_a_link_that_begins_over_the_floor_stays_there():
    """The second bar begins raised: what counts is the motion's start and not the zero pose."""
    shape = geometry_of(lying(), radius=0.04, floor=0.08, begin=np.array([0.3, 0.0]))
    assert [link.least for link in shape.grounded] == [0.0, 0.0]
    assert not any("below the floor" in note for note in shape.notes)
    assert floors([(0.3, 0.0), (0.0, 0.0)], 0.08, (0.3, 0.0))["link 2 and the floor"] == pytest.approx(-0.02)


def test_an_arm_wholly_below_the_floor_is_sunk():
    shape = geometry_of(lying(), radius=0.04, floor=0.5)
    assert shape.sunk == ("link 1", "link 2")
    assert floors([(0.0, 0.0)], 0.5)["link 1 and the floor"] == pytest.approx(0.1 - 0.04 - 0.5)


def test_what_stands_on_the_base_is_not_held_against_the_floor():
    """The first link of this arm begins in the base, and only its other end moves."""
    shape = geometry_of(load_robot("four_link"), radius=0.06)
    assert [link.least for link in shape.grounded] == [0.0] * len(shape.grounded)
    assert not any("below the floor" in note for note in shape.notes)


@pytest.mark.parametrize(("floor", "confined_by"), [(0.0, ["link 2 and the floor"]), (-5.0, [])])
def test_a_motion_that_links_confine_says_so(floor, confined_by):
    """Swings of 0.11 of 2 rad, which bring the second bar's end near a floor 0.06 m below it."""
    many = np.ones(2)
    limits = Limits(-many, many, 9 * many, 99 * many, 99 * many, np.zeros(2))
    shape = geometry_of(lying(), radius=0.04, floor=floor)
    task = Task(lying(), limits, shape, {}, 4.0, 50.0)
    time = np.arange(201) / 50
    swing = 0.055 * np.sin(np.pi * time / 2)
    plan = Experiment(time, np.column_stack([swing, 0 * swing]), np.zeros((201, 2)))
    told = confined(task, plan)
    assert len(told) == len(confined_by)
    for sentence, where in zip(told, confined_by, strict=True):
        assert f"(joint1 to 6 %, joint2 to 0 % of the range), as {where} would touch" in sentence
