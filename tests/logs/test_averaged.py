"""Logs of more samples a second than a judgement needs."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint

import pyident as pi
from flexmodels.settings.processing import Processing
from pyident.logs.averaged import averaged
from pyident.logs.log import Log
from pyident.verbs.inputs import given


def log(rate: float, seconds: float = 2.0, ripple: float = 0.0) -> Log:
    """Whose torque has white noise of 0.01 N m, and a ripple [N m] of 127 to 255 Hz."""
    t = np.arange(round(rate * seconds)) / rate
    q = 6 * t + np.sin(2 * t)
    noise = 0.01 * np.random.default_rng(0).standard_normal(len(t))
    columns = {
        "time": t,
        "joint1.e": np.sin(3 * t),
        "joint1.tau": -9 * np.sin(3 * t) + noise + ripple * np.sin(200 * q),
        "joint1.on": (t > 1.0003) * 1.0,
    }
    return Log.from_frame(pd.DataFrame(columns))


@pytest.mark.parametrize(
    ("rate", "ripple", "left"),
    [
        (500, 0.0, 500),
        (900, 0.0, 900),
        (1000, 0.0, 500),
        (5000, 0.0, 500),
        (1000, 0.01, 1000),
        (1900, 0.01, 1900),
        (2000, 0.01, 1000),
        (5000, 0.03, 1000),
    ],
)
def test_a_fast_log_is_thinned_out_by_means(rate, ripple, left):
    """Further where its torques hold nothing but noise above 150 Hz; a ripple of 130 to 250 Hz is more."""
    ((found,), notes) = averaged([log(rate, 8.0, ripple)])
    assert 1 / found.period == pytest.approx(left)
    assert bool(notes) == (left != rate)
    t = found.frame["time"].to_numpy()
    assert found.frame["joint1.e"].to_numpy() == pytest.approx(np.sin(3 * t), abs=1e-5)


def test_a_motor_counts_as_on_where_it_is_on_throughout():
    ((found,), _) = averaged([log(5000)])
    time, on = (found.frame[name].to_numpy() for name in ("time", "joint1.on"))
    assert set(on) == {0.0, 1.0}
    assert time[on == 1].min() == pytest.approx(1.0029)


def test_what_is_left_tells_the_same_law():
    """An inertia and a viscous friction, of white noise at 4 kHz and of its means."""
    rng = np.random.default_rng(5)
    t = np.arange(16000) / 4000
    q, dq, ddq = (
        sum(a * w**n * np.sin(w * t + p + n * np.pi / 2) for a, w, p in ((0.5, 5.0, 0.3), (0.2, 17.0, 1.1)))
        for n in range(3)
    )
    tau = 0.8 * ddq + 1.5 * dq + 0.02 * rng.standard_normal(len(t))
    frame = pd.DataFrame({"time": t, "joint1.e": q, "joint1.tau": tau})
    whole = [frame.iloc[i : i + 8000].reset_index(drop=True) for i in (0, 8000)]
    robot = replace(one_joint(), controller=None)
    found = pi.diagnose(robot, whole[:1], heldout=whole[1:])
    assert found.verdict == "nothing_detectable"
    assert any(note.startswith("4000 samples a second") for note in found.notes)


def test_a_robot_file_with_a_filter_of_its_own_gets_every_sample():
    """Its factor is one of samples: of means it would leave a quarter."""
    thins = Processing(cutoff=100.0, decimate=20)
    robot = replace(one_joint(), controller=None)
    read = given(robot.with_settings(processing=thins), [log(4000).frame])
    assert len(read.logs[0]) == 8000
    assert len(given(robot, [log(4000).frame]).logs[0]) == 1000
