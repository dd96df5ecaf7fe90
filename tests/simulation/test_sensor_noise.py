"""Noise of sensors from the regression's residual, against the noise that was added."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import analytic_log, free_joint

from pyident.simulation.noise.sensor_noise import _raised, _shared, sensor_noise


def _estimate(**noise):
    robot = free_joint()
    p = np.array(list(robot.linear_parameters.values()))
    logs = [analytic_log(seed=seed, **noise) for seed in range(2)]
    return sensor_noise(robot, logs, p)


@pytest.mark.parametrize(("angle", "torque"), [(2e-6, 0.05), (1e-5, 0.05), (2e-6, 0.5)])
def test_angle_and_torque_are_told_apart(angle, torque):
    """An angle's noise is differentiated twice, so it grows as f² where that of a torque is flat."""
    found = _estimate(angle_noise=angle, torque_noise=torque)
    in_torque = 1.1 * 2.9 / 0.004**2 * angle  # of the second difference: its share of the residual
    if in_torque > 0.3 * torque:
        assert found["joint1.e"] == pytest.approx(angle, rel=0.25)
    if torque > 0.3 * in_torque:  # below, its power is less than what 4000 samples leave open of the angle's
        assert found["joint1.tau"] == pytest.approx(torque, rel=0.25)


def test_a_clean_log_has_none():
    found = _estimate()
    assert found["joint1.e"] < 1e-8
    assert found["joint1.tau"] < 1e-3


def test_sensors_of_a_kind_whose_patterns_agree_are_none_of_them_read_as_silent():
    """Powers of short logs scatter; what they leave open between two sensors goes to both."""
    rng = np.random.default_rng(0)
    least = []
    for _ in range(50):
        shape = rng.uniform(0.5, 2.0, (32, 1))
        patterns = np.hstack([shape, shape * rng.uniform(0.8, 1.25, (32, 1))])
        power = patterns.sum(axis=1) * rng.chisquare(30, 32) / 30
        least.append(_shared(power, patterns, [["joint1.eps[1]", "joint1.eps[2]"]]).min())
    assert min(least) > 0.5


def test_short_logs_are_not_read_too_quiet():
    """Powers of few frequencies scatter by a fifth; relative to themselves they would read 12 % low."""
    rng = np.random.default_rng(1)
    course = np.repeat(np.linspace(1.0, 5.0, 8)[None], 12, axis=0)
    found = []
    for _ in range(40):
        patterns = np.stack([course * rng.chisquare(50, course.shape) / 50 for _ in range(12)], axis=-1)
        patterns = patterns * np.eye(12)[:, None]  # every sensor has a row of its own
        power = (course * rng.chisquare(50, course.shape) / 50).ravel()
        flat = patterns.reshape(-1, 12)
        shared = _shared(power, flat, [[f"joint{k}.e" for k in range(12)]])
        found.append((shared.mean(), (shared * _raised(power, flat @ shared)).mean()))
    low, raised = np.mean(found, axis=0)
    assert low < 0.92
    assert raised == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("at", [0.0, 0.3])
def test_a_log_in_which_all_stands_still_has_no_noise(at):
    log = analytic_log()
    frame = log.frame.assign(**{"joint1.e": at, "joint1.tau": 4.5e-5})
    p = np.array(list(free_joint().linear_parameters.values()))
    assert sensor_noise(free_joint(), [replace(log, frame=frame)], p) == {"joint1.e": 0.0, "joint1.tau": 0.0}


def test_a_sensor_that_no_equation_shows_is_no_division_by_zero():
    """The first alone makes the power, with a variance of 4; the second has no pattern."""
    patterns = np.column_stack([np.linspace(1, 2, 16), np.zeros(16)])
    found = _shared(4 * patterns[:, 0], patterns, [["joint1.e"], ["joint2.e"]])
    assert found == pytest.approx([4.0, 0.0], abs=1e-6)
    assert _shared(np.ones(16), np.zeros((16, 2)), [["joint1.e"], ["joint2.e"]]) == pytest.approx([0.0, 0.0])


def test_what_may_have_none_has_none():
    """Of two sensors that make the same power the second is bounded: the first one's is all of it."""
    patterns = np.column_stack([np.linspace(1, 2, 16), np.linspace(1, 2, 16)])
    found = _shared(4 * patterns[:, 0], patterns, [["joint1.e"], ["joint1.tau"]], np.array([np.inf, 0.0]))
    assert found == pytest.approx([4.0, 0.0], abs=1e-6)
