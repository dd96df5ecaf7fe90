"""Twists that are the difference of two encoders, by the noise that they share."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pyident.logs.encoders import second_encoders
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


def exact(motor, link):
    return motor, link - motor


@pytest.mark.parametrize(
    ("read", "second"), [(two_encoders, True), (noisy, True), (strain, False), (finer, False), (exact, False)]
)
def test_two_encoders_of_one_step_are_told_from_a_sensor_of_the_twist(read, second):
    assert second_encoders(frame(read)) == ({"joint1.eps[1]": "joint1.e"} if second else {})


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
