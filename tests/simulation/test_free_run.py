"""Free runs under recorded torques, against the closed form of a mass with viscous friction."""

import numpy as np
import pandas as pd
import pytest

import pyident as pi
from flexmodels.files.robot_file import load_robot
from pyident.logs.log import Log, LogError
from pyident.simulation.free_run import free_run_of, plant_of, run_freely

M, FV, STEP = 80.0, 200.0, 1e-3
# 0.3 m/s, which falls by a tenth in 40 ms: a quadratic through 20 ms leaves 6e-5 m/s at its end,
# times M / FV.
CURVE = 3e-5  # m


def axis():
    robot = load_robot("emps")
    return robot.with_parameters({"link1.m": M, "joint1.viscous": FV, "joint1.coulomb": 0.0})


def decay(time, speed, position):
    """Speed and position of a mass that only its viscous friction slows down."""
    fade = np.exp(-FV / M * time)
    return speed * fade, position + speed * M / FV * (1 - fade)


def coasting(start=0.0, N=1500):
    """A log of it: quadratic in its window nearly, exponential behind."""
    time = np.arange(N) * STEP
    _, e = decay(time, 0.3, 0.05)
    return Log(pd.DataFrame({"time": time + start, "joint1.e": e, "joint1.tau": np.zeros(N)}), "coasting")


def test_a_coasting_mass_follows_the_closed_form():
    log = coasting(start=3.0)
    frame = run_freely(axis(), log).frame
    np.testing.assert_array_equal(frame["time"], log.frame["time"])
    np.testing.assert_array_equal(frame["joint1.e"][:20], log.frame["joint1.e"][:20])
    np.testing.assert_allclose(frame["joint1.e"], log.frame["joint1.e"], atol=CURVE)


def test_torques_are_held_between_samples():
    """A mass without friction under F: after n samples from rest, F t² / 2 M exactly."""
    N, F = 400, 12.0
    torque = np.full(N, F)
    torque[:20] = 0.0
    frame = pd.DataFrame({"time": np.arange(N) * STEP, "joint1.e": np.zeros(N), "joint1.tau": torque})
    robot = axis().with_parameters({"joint1.viscous": 0.0})
    made = run_freely(robot, Log(frame, "pushed")).frame["joint1.e"].to_numpy()
    t = (np.arange(N) - 20) * STEP
    np.testing.assert_allclose(made[20:], F / M * t[20:] ** 2 / 2, atol=1e-12)


def test_nothing_behind_the_window_is_looked_at():
    log = coasting()
    spoilt = log.frame.assign(**{"joint1.e": log.frame["joint1.e"].where(log.frame.index < 20, 7.0)})
    a, b = (run_freely(axis(), Log(f, "x")).frame["joint1.e"] for f in (log.frame, spoilt))
    np.testing.assert_array_equal(a, b)


def test_parts_set_out_from_their_own_windows():
    log = coasting()
    run = free_run_of(axis(), log, part=(500, 1500))
    speed, _ = decay(np.array([519 * STEP]), 0.3, 0.05)
    assert run.start["joint1.de_0"] == pytest.approx(speed[0], rel=2e-3)  # a quadratic for an exponential
    with plant_of(axis()) as plant:
        missed = run.missed(plant, [axis().parameters])[0]
    assert missed.shape == (980, 1)
    assert np.abs(missed).max() < CURVE


@pytest.mark.parametrize(
    ("dropped", "window", "words"),
    [
        ("joint1.tau", 20, "joint1.tau"),
        ("joint1.e", 20, "joint1.e"),
        (None, 2, "window"),
        (None, 1500, "window"),
    ],
)
def test_what_lacks_is_said(dropped, window, words):
    frame = coasting().frame.drop(columns=dropped or [])
    with pytest.raises(LogError, match=words):
        free_run_of(axis(), Log(frame, "coasting"), window)


def test_simulate_runs_freely_where_nothing_controls(tmp_path):
    path = tmp_path / "other.csv"
    frame = coasting().frame.rename(columns={"time": "t", "joint1.e": "qm", "joint1.tau": "vir"})
    frame.assign(qg=0.0).to_csv(path, index=False)
    log = pi.simulate(axis(), path)
    assert np.abs(log.frame["joint1.e"] - coasting().frame["joint1.e"]).max() < CURVE
    assert "misses" in log.notes[0]
