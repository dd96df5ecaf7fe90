"""Twists that are the difference of two encoders, by the noise that they share."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pyident.logs.encoders import resolution, second_encoders
from pyident.logs.log import Log
from pyident.simulation.replica import Repeat

STEP = 2 * np.pi / 2**17


def frame(read) -> pd.DataFrame:
    """A joint that swings on its spring; read: motor and link (N,) -> motor and twist as they are logged."""
    t = np.arange(5000) / 500
    link = 0.5 * np.sin(2 * t) + 0.1 * np.sin(9 * t)
    motor = link + 0.012 * np.sin(2 * t + 0.3)
    e, eps = read(motor, link)
    return pd.DataFrame({"time": t, "joint1.e": e, "joint1.eps[1]": eps})


def rounded(x: np.ndarray, step: float = STEP) -> np.ndarray:
    return np.round(x / step) * step


def two_encoders(motor, link):
    return rounded(motor), rounded(link) - rounded(motor)


def noisy(motor, link):
    rng = np.random.default_rng(0)
    return two_encoders(motor + STEP * rng.standard_normal(5000), link + STEP * rng.standard_normal(5000))


def strain(motor, link):
    return rounded(motor), rounded(link - motor)


def finer(motor, link):
    return rounded(motor), rounded(link - motor, STEP / 3)


def finer_link(motor, link):
    """Of 20 bits beside 17."""
    return rounded(motor), rounded(link, STEP / 8) - rounded(motor)


def link_of_other_steps(motor, link):
    """As behind a belt, and a motor that answers to its encoder's noise."""
    shaken = motor + STEP * np.random.default_rng(1).standard_normal(5000)
    return rounded(shaken), rounded(link, 0.7 * STEP) - rounded(shaken)


def exact(motor, link):
    return motor, link - motor


@pytest.mark.parametrize(
    ("read", "second"),
    [
        *((read, True) for read in (two_encoders, noisy, finer_link, link_of_other_steps)),
        *((read, False) for read in (strain, finer, exact)),
    ],
)
def test_two_encoders_are_told_from_a_sensor_of_the_twist(read, second):
    assert second_encoders(frame(read)) == ({"joint1.eps[1]": "joint1.e"} if second else {})


@pytest.mark.parametrize("digits", [12, 9])
def test_the_step_shows_where_hardly_any_change_is_of_one(digits):
    """Of a joint that passes thousands a sample, in a text that rounds to a four-hundredth of one, too."""
    step, t = 4.79e-7, np.arange(20_000) / 500
    x = np.round(rounded(1.2 * np.sin(2.1 * t) + 0.4 * np.sin(5.3 * t), step), digits)
    assert np.mean(np.abs(np.diff(x)) < 20 * step) < 0.005
    assert resolution(x) == pytest.approx(step, rel=1e-3)


def test_noise_has_no_step():
    x = 1e-6 * np.random.default_rng(0).standard_normal(5000).cumsum()
    assert resolution(x) == 0.0


def test_without_a_twist_there_is_none():
    assert second_encoders(frame(two_encoders).drop(columns="joint1.eps[1]")) == {}


def test_a_replica_has_the_noise_of_both_in_its_twist():
    """The link that is put together from the two has that of its own encoder alone."""
    log = Log.from_frame(frame(two_encoders).assign(**{"joint1.tau": 0.0}))
    plan: Any = SimpleNamespace(time=np.zeros(20_000))
    drawn = Repeat(log, plan)._drawn({"joint1.e": 3.0, "joint1.eps[1]": 2.0}, seed=1)
    link = drawn["joint1.e"] + drawn["joint1.eps[1]"]
    assert [np.std(x) for x in (drawn["joint1.e"], link)] == pytest.approx([3.0, 2.0], rel=0.02)
    assert np.std(drawn["joint1.eps[1]"]) == pytest.approx(np.hypot(3.0, 2.0), rel=0.02)
    assert np.corrcoef(drawn["joint1.e"], link)[0, 1] == pytest.approx(0.0, abs=0.03)
