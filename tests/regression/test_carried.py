"""Loads of a log's motion are those of the robot, not of its encoders' noise."""

from dataclasses import replace

import numpy as np
import pytest
from studies.log_checks.swings import six_axes
from studies.rigid_arm.pinocchio_chain import chain, inverse_dynamics

from pyident.conditioning.motion import Motion
from pyident.conditioning.weak_form import central_differences
from pyident.regression.loads.bodies import carried_loads, link_torques

ROBOT, PERIOD = six_axes(), 0.004


@pytest.fixture(scope="module")
def measured():
    """A motion as differences of noisy positions give it, and the loads of the true one."""
    rng = np.random.default_rng(3)
    time = np.arange(0, 10, PERIOD)
    w, a, phase = 2 * np.pi * rng.uniform(0.1, 0.6, 6), rng.uniform(0.3, 0.8, 6), rng.uniform(0, 6, 6)
    angle = np.outer(time, w) + phase
    q, v, dv = a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle)
    true = inverse_dynamics(chain(ROBOT), q, v, dv)
    noisy = q + 1e-5 * rng.standard_normal(q.shape)
    return Motion(*central_differences(np.pad(noisy, ((4, 4), (0, 0)), mode="edge"), PERIOD), time=time), true


def test_noise_that_differences_raise_does_not_turn_a_load(measured):
    motion, true = measured
    inner = slice(300, -300)  # a low pass knows less at the ends
    error = [
        np.std(loads(ROBOT, motion)[inner] - true[inner], axis=0) for loads in (carried_loads, link_torques)
    ]
    own = slice(0, 5)  # nothing loads the last axis
    assert (error[0] < 0.1 * error[1])[own].all()
    assert (error[0] < 0.3 * np.std(true, axis=0))[own].all()


def test_samples_that_are_no_log_stay_as_they_are(measured):
    motion, _ = measured
    loose = replace(motion, time=None)
    np.testing.assert_array_equal(carried_loads(ROBOT, loose), link_torques(ROBOT, loose))
