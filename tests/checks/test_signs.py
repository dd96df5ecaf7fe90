"""A torque against its motion, on a log of the equation of motion."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import COULOMB, analytic_log, free_joint
from studies.rigid_arm.arm import COULOMB as COULOMBS
from studies.rigid_arm.arm import ROTOR, VISCOUS, arm, moved, recorded

from pyident.checks.balances import balances, samples, solved
from pyident.checks.signs import signs


@pytest.mark.parametrize("column", ["joint1.tau", "joint1.e"])
def test_a_wrong_sign_feeds_energy_in(column):
    sound = analytic_log(torque_noise=0.02)
    turned = replace(sound, frame=sound.frame.assign(**{column: -sound.frame[column]}))
    for log, count in ((sound, 0), (turned, 1)):
        signals = samples(free_joint(), log)
        assert signals is not None
        found = list(signs(balances(signals), log.source))
        assert len(found) == count
    (defect,) = found
    assert (defect.severity, defect.kind, defect.channel) == ("gross", "sign", "joint1.tau")
    assert "joint1.tau has the wrong sign against joint1.e: friction would feed energy in" in defect.sentence


def test_without_friction_the_inertia_tells():
    robot = free_joint()
    (joint,) = robot.joints
    smooth = replace(robot, joints=(replace(joint, values={"motor_inertia": {"J_m": 0.5}}),))
    log = analytic_log()
    e = log.frame["joint1.e"].to_numpy()
    wrong = replace(log, frame=log.frame.assign(**{"joint1.tau": _inertial(e, log.period)}))
    signals = samples(smooth, wrong)
    assert signals is not None
    (defect,) = signs(balances(signals), "a log")
    assert "its inertia would be negative" in defect.sentence


def test_friction_is_smoothed_as_the_torques_are():
    """Slow motion at 100 Hz, where the filter reaches far: a step that is not smoothed read 0.8 N m."""
    signals = samples(free_joint(), analytic_log(seconds=40.0, period=0.01))
    assert signals is not None
    of = balances(signals)
    right, power = of.right(0, of.torque)
    p = dict(zip(of.columns, solved(of.normal[0], right)[0][:, 0], strict=True))
    assert p["joint1.coulomb"] == pytest.approx(COULOMB, rel=0.01)
    assert of.left(0, of.torque)[0] < 1e-5 * power[0]


def _inertial(e, period):
    """-1.1 kg m² times the acceleration."""
    from numpy import gradient

    return -1.1 * gradient(gradient(e, period), period)


def test_a_spring_is_no_wrong_sign():
    """Of 40 N m/rad at a joint that swings at 0.5 Hz: more than its inertia's torque, and against it."""
    sound = analytic_log(torque_noise=0.02)
    e = sound.frame["joint1.e"]
    hung = replace(sound, frame=sound.frame.assign(**{"joint1.tau": sound.frame["joint1.tau"] + 40 * e}))
    signals = samples(free_joint(), hung)
    assert signals is not None
    assert not list(signs(balances(signals), hung.source))


def test_what_drives_one_joint_is_no_wrong_sign_and_reversed_rows_are():
    """Inertia is right in both; in reversed rows friction drives every joint."""
    pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")
    rng, robot = np.random.default_rng(3), arm()
    motion = moved(robot, rng, 20.0, 3.0)
    friction = COULOMBS * np.sign(motion.v) + VISCOUS * motion.v
    tau = motion.load + ROTOR * motion.a + friction

    def found(tau, way=1):
        log = recorded(motion, tau, np.zeros(6), rng, "log")
        turned = log.frame.iloc[::way].reset_index(drop=True).assign(time=log.frame["time"])
        signals = samples(robot, replace(log, frame=turned))
        assert signals is not None
        return [defect.channel for defect in signs(balances(signals), "log")]

    spins = np.zeros_like(tau)  # a force between two wrist axes that takes no power, as of a gyroscope
    spins[:, 4], spins[:, 3] = 3.0 * motion.v[:, 3], -3.0 * motion.v[:, 4]
    driven = tau.copy()
    driven[:, 1] -= 3 * friction[:, 1]
    assert found(tau) == []
    assert found(driven) == []
    assert found(tau + spins) == []
    turned = (tau + spins) * np.where(np.arange(6) == 4, -1, 1)
    assert "joint5.tau" in found(turned)
    assert len(found(tau, -1)) > 2


def test_sensors_behind_the_gears_feel_no_friction_that_could_tell_a_sign():
    """What noise or a contact makes of it may drive one joint; signs that are turned are found."""
    pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")
    rng, robot = np.random.default_rng(5), arm()
    motion = moved(robot, rng, 20.0, 3.0)
    seems = np.zeros_like(motion.load)
    seems[:, 2] = -0.2 * motion.load[:, 2].std() * np.sign(motion.v[:, 2])

    def found(tau):
        log = recorded(motion, tau, 1e-3 * motion.load.std(axis=0), rng, "log")
        signals = samples(robot, log)
        assert signals is not None
        return [defect.channel for defect in signs(balances(signals), "log")]

    assert found(motion.load + seems) == []
    turned = motion.load.copy()
    turned[:, 1:3] *= -1
    assert set(found(turned)) & {"joint2.tau", "joint3.tau"}
