"""The floor: errors that no model is free of, in every replica; and what stands out above it."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from one_joint import PERIOD, one_joint

from pyident.diagnosis.base.discrepancy import inexact
from pyident.diagnosis.base.projection import Base
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.diagnosis.search.search import Search
from pyident.logs.log import Log
from pyident.rules.rules import RULES

TIME = np.arange(4000) * PERIOD


def _change(torque: np.ndarray, share: float, friction: float) -> np.ndarray:
    """Of the torque, along sin t; the robot's Coulomb friction is `friction` [N m]."""
    log = Log(pd.DataFrame({"time": TIME, "joint1.e": np.sin(TIME), "joint1.tau": torque}), "a log")
    robot = one_joint().with_parameters({"joint1.coulomb": friction})
    made = inexact(robot, log, share, seed=5)
    assert np.array_equal(made.frame["joint1.e"], log.frame["joint1.e"])
    return made.frame["joint1.tau"].to_numpy() - torque


def test_an_error_has_its_share_of_the_torque_and_none_of_its_mean():
    noise = np.random.default_rng(0).standard_normal(4000)
    assert np.std(_change(50 + noise, 1e-3, 0.0)) == pytest.approx(1e-3, rel=0.1)


def test_an_error_is_where_the_torque_is():
    power = np.abs(np.fft.rfft(_change(np.sin(2 * np.pi * 10 * TIME), 1e-3, 0.0))) ** 2
    f = np.fft.rfftfreq(4000, PERIOD)
    assert power[np.abs(f - 10) < 1].sum() > 0.99 * power.sum()


def test_friction_is_rounded_near_rest_alone_and_never_more_than_it_is():
    speed = np.cos(TIME)
    change = _change(np.zeros(4000), 0.0, 3.0)
    assert (change * speed <= 0).all()  # less friction
    assert 0.5 < np.abs(change).max() <= 3.0
    assert np.abs(change[np.abs(speed) > 0.1]).max() < 3e-3  # 7 % of the rms speed


SAMPLES = 100
CALM, WILD = [1.0] * 20, [0.2] * 19 + [16.2]  # energy that each of 20 replicas leaves: on average 1


class Fitted:
    rules = RULES


def standing_out(energy: float, replicas: list[float]) -> bool:
    """Of one equation whose residual has this mean square."""
    setting: Any = Fitted()
    count, nothing = np.array([SAMPLES]), np.zeros((20, 0))
    left = np.reshape(replicas, (20, 1, 1))
    floor: Any = None
    residual = np.full((1, SAMPLES), np.sqrt(energy))
    base = Base(np.zeros(0), np.zeros((0, 0)), [], [residual])
    examined: Any = ([], [], [], nothing, [], np.array([[energy]]), left, count)
    examination = Examination(setting, floor, [], base, *examined)
    families: Any = None
    return bool(Search(examination, families, base).standing_out[0])


@pytest.mark.parametrize(
    ("energy", "replicas", "stands_out"),
    [(1.9, CALM, False), (2.1, CALM, True), (15.0, WILD, False), (17.0, WILD, True)],
)
def test_what_a_perfect_model_leaves_as_well_does_not_stand_out(energy, replicas, stands_out):
    assert standing_out(energy, replicas) == stands_out
