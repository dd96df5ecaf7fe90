"""A servo's numbers from positions alone, out of logs that a simulation of its own made."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import least_squares
from scipy.stats import t
from servo_pendulum import by_hand, guessed, pendulum, stepped

import pyident as pi
from flexmodels.inputs import Experiment
from pyident.logs.log import Log
from pyident.refinement.closed_loop import _ROUGH, _jackknife


def _log(number: int) -> Log:
    """1.5 s of a swing, made by SciPy with another armature and torque constant than the robot file has."""
    time = np.arange(301) * 0.005
    reference = (0.7 * np.sin(2 * np.pi * (0.6 + 0.4 * number) * time) + 0.2 * number)[:, None]
    plan = Experiment(time, reference, 0 * reference, np.ones_like(reference), np.array([0.2]))
    e = by_hand(plan, armature=0.004, kt=0.28)
    noise = 1e-3 * np.random.default_rng(number).standard_normal(len(e))
    noise[0] = 0.0
    return Log(
        pd.DataFrame({"time": time, "joint1.r": reference[:, 0], "joint1.e": e + noise}), f"log {number}"
    )


@pytest.fixture(scope="module")
def logs():
    return [_log(number) for number in range(3)]


def test_armature_and_torque_constant_without_any_torque(logs):
    found = pi.identify_servo(pendulum(), logs, free=["joint1.J_m", "joint1.servo.kt"])
    assert found.fit.values["joint1.J_m"] == pytest.approx(0.004, rel=0.03)
    assert found.fit.values["joint1.servo.kt"] == pytest.approx(0.28, rel=0.01)
    assert found.fit.std is not None
    assert max(found.fit.error) < 1.2e-3  # the noise's own mean is 0.8e-3


@pytest.mark.parametrize("spread", [0.003, 0.03, 0.3])
def test_intervals_are_those_of_leaving_out_each_log(spread):
    """A line through logs whose errors count by their square, in part, or by their size."""
    rng = np.random.default_rng(3)
    x = rng.standard_normal((8, 60, 2))
    y = (
        x @ np.array([1.0, -2.0])
        + spread * rng.standard_normal((8, 60))
        + spread * rng.standard_normal((8, 1))
    )

    def fit(logs):
        A, b = x[logs].reshape(-1, 2), y[logs].ravel()
        return least_squares(lambda p: A @ p - b, [0, 0], loss="soft_l1", f_scale=_ROUGH)

    best, free = fit(np.arange(8)), np.ones(2, bool)
    told = _jackknife(best.jac, best.fun, [60] * 8, np.array([1.0, 2.0]), free)
    left_out = np.array([fit(np.delete(np.arange(8), k)).x for k in range(8)])
    exact = np.sqrt(7 / 8 * np.square(left_out - left_out.mean(axis=0)).sum(axis=0))
    np.testing.assert_allclose(told, exact * t.ppf(0.975, 7) / 1.96, rtol=0.1)
    on_bound = _jackknife(best.jac, best.fun, [60] * 8, np.ones(2), np.array([True, False]))
    assert np.isfinite(on_bound).tolist() == [True, False]


def test_the_robot_itself_is_the_start_and_stays_as_it_was(logs):
    robot = pendulum()
    found = pi.identify_servo(robot, logs[:2], free=["joint1.J_m"])
    assert found.fit.std is None
    assert "three logs" in found.summary()
    assert found.robot.servo == robot.servo


def test_what_cannot_be_found_is_said(logs):
    with pytest.raises(pi.RobotError, match=r"no parameter joint1\.magic"):
        pi.identify_servo(pendulum(), logs, free=["joint1.magic"])
    with pytest.raises(pi.RobotError, match=r"2 settings for 3 logs"):
        pi.identify_servo(pendulum(), logs, settings=[{}, {}])
    with pytest.raises(pi.RobotError, match=r"no parameter servo\.kq"):
        pi.identify_servo(pendulum(), logs, settings=[{"servo.kq": 1.0}] * 3)


def test_values_at_a_bound_and_positions_far_from_their_noise_are_said(logs):
    """Commands that were written down in another scale."""
    scaled = [Log(log.frame.assign(**{"joint1.r": 0.8 * log.frame["joint1.r"]}), log.source) for log in logs]
    found = pi.identify_servo(pendulum(), scaled, free=["joint1.J_m", "joint1.servo.kt", "servo.delay"])
    assert found.fit.at_bound
    said = str(found.summary())
    assert "at the least value that it may have" in said
    assert "times what the encoders' noise leaves" in said
    assert "at the least value" not in str(pi.identify_servo(pendulum(), logs[:1]).summary())


def test_what_no_simulation_follows_is_refused_unless_forced(logs):
    """Positions of another robot: they lie beside the commands."""
    time = logs[0].frame["time"]
    other = logs[0].frame.assign(**{"joint1.e": logs[0].frame["joint1.r"] * (1 + 1e-3 * np.sin(40 * time))})
    with pytest.raises(pi.LogError, match="no simulation of robot pendulum comes nearer to the positions"):
        pi.identify_servo(pendulum(), other, free=["joint1.viscous"])
    forced = pi.identify_servo(pendulum(), other, free=["joint1.viscous"], force=True)
    assert "do not use these values" in str(forced.summary())


def test_what_moves_nothing_stays_as_it_was_and_is_said(logs):
    still = logs[0].frame.assign(**{"joint1.r": 0.0, "joint1.e": 0.0})
    found = pi.identify_servo(pendulum(), still, free=["joint1.J_m"], force=True)
    assert found.fit.unseen == ("joint1.J_m",)
    assert "no position moves with them: joint1.J_m" in str(found.summary())


def test_commands_that_jump_between_samples_are_no_missing_effect():
    """Poses, one after the other, at 100 Hz: nothing tells when in a sample the command came."""
    rng, time = np.random.default_rng(3), 1e-3 * np.arange(8000)
    poses = np.repeat(rng.uniform(-0.8, 0.8, 11), [613, 571, 847, 702, 689, 934, 588, 777, 641, 803, 835])
    shaken = 0.8 * np.sin(3 * time) * np.minimum(time, 1)
    logs = []
    for r in (poses, shaken):
        frame = pd.DataFrame({"time": time[::10], "joint1.r": r[::10], "joint1.e": stepped(r)[::10]})
        logs.append(Log(frame, "log"))
    found = pi.identify_servo(guessed(), logs)
    assert found.fit.noise[0] > 2 * found.fit.noise[1]
    assert "noise leaves" not in str(found.summary())
