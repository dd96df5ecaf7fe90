"""What stands in where nothing says how the torque of a log was made."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint
from studies.rigid_arm.arm import COULOMB, ROTOR, VISCOUS, arm, moved, recorded

import pyident as pi
from flexmodels.experiment import Experiment
from pyident.conditioning.motion import Motion
from pyident.logs.log import Log
from pyident.refinement.instruments.stand_in import driven, smoothed
from pyident.regression.regressor import generalised_forces
from pyident.simulation.replica import Repeat

TIME = np.arange(2000) * 0.004


def test_a_robot_is_driven_by_its_controller():
    assert driven(one_joint())
    assert not driven(replace(one_joint(), controller=None))


def test_inputs_keep_what_is_slow_without_delay_and_lose_what_is_fast():
    """3 Hz passes as it is; 90 Hz of a Nyquist frequency of 125 does not. The torque is the model's."""
    robot = one_joint()
    omega = 2 * np.pi * 3
    slow, fast = 0.1 * np.sin(omega * TIME), 1e-3 * np.sin(2 * np.pi * 90 * TIME)
    q = (slow + fast)[:, None]
    names, weight = list(robot.coordinates), 3.0
    logged = np.random.default_rng(1).standard_normal((len(TIME), 1))
    frame = pd.DataFrame({"time": TIME} | {name: slow + fast for name in names[:1]})
    frame = frame.assign(**{name: 0.0 for name in names[1:]}, **{"joint1.tau": logged[:, 0]})
    plan = Experiment(TIME, q, logged - weight)
    again = smoothed(robot, Repeat(Log(frame, "log"), plan))
    inside = slice(200, -200)
    np.testing.assert_allclose(again.plan.reference[inside, 0], slow[inside], atol=1e-4)
    np.testing.assert_array_equal(again.plan.time, TIME)
    motion = np.zeros((3, len(TIME), len(names)))
    motion[:, :, 0] = slow, 0.1 * omega * np.cos(omega * TIME), -(omega**2) * slow
    p = np.array(list(robot.linear_parameters.values()))
    needed = generalised_forces(robot, Motion(motion[0], motion[1], motion[2], logged, TIME), p)[:, 0]
    away = np.abs(motion[1, inside, 0]) > 1.0  # from the steps of friction, which lose their corners
    error = (again.plan.feedforward[:, 0] + weight - needed)[inside][away]
    assert np.sqrt(np.mean(error**2)) < 0.05 * needed.std()


def test_noise_of_the_torque_does_not_pass_for_inertia():
    """An arm without friction and rotors, whose torques shake: fed with them a model finds them too heavy."""
    pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")
    z = []
    for seed in range(2):
        rng, robot = np.random.default_rng(seed), arm()
        motion = moved(robot, rng, 15.0, 4.0)
        log = recorded(motion, motion.load, 0.3 * motion.load.std(axis=0), rng, "log")
        found = pi.identify(robot, log).identified
        names = list(found.reduced.columns)
        told = [
            i for i, name in enumerate(names) if name.startswith("joint") and found.support[name] == "alone"
        ]
        z.append(found.solution.p[told] / found.solution.std[told])  # of what is zero
    assert all(np.sqrt(np.mean(np.square(one))) < 1.2 for one in z)
    assert max(np.abs(one).max() for one in z) < 3


def test_noise_of_encoders_does_not_pass_for_motion_where_samples_are_dense():
    """At 5 kHz a share of the Nyquist frequency lets through accelerations that are the encoders' noise."""
    pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")
    rng, robot = np.random.default_rng(3), arm()
    motion = moved(robot, rng, 6.0, 6.0, rate=5000.0)
    tau = motion.load + ROTOR * motion.a + COULOMB * np.sign(motion.v) + VISCOUS * motion.v
    motion = replace(motion, q=motion.q + 2e-5 * rng.standard_normal(motion.q.shape))
    log = recorded(motion, tau, 0.01 * tau.std(axis=0), rng, "log")
    found = pi.identify(robot, log).identified
    truth = {"J_m": ROTOR, "coulomb": COULOMB, "viscous": VISCOUS}
    z = {
        name: (found.solution.p[i] - truth[quantity][k]) / found.solution.std[i]
        for k in range(6)
        for quantity in truth
        for i, name in enumerate(found.reduced.columns)
        if name == f"joint{k + 1}.{quantity}" and found.support[name] == "alone"
    }
    assert len(z) >= 15
    assert np.mean(np.abs(list(z.values())) < 1.96) > 0.85
    assert max(np.abs(list(z.values()))) < 4
