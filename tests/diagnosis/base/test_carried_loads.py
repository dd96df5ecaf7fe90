"""The bodies whose loads belong to friction under load, against Pinocchio's loads of the same arm."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from analytic_joint import analytic_log
from one_joint import one_joint
from studies.log_checks.swings import six_axes
from studies.rigid_arm.pinocchio_chain import chain, inverse_dynamics

from flexmodels.settings.processing import Processing
from pyident.diagnosis.base.carried_loads import with_carried_loads
from pyident.diagnosis.base.projection import solve_base
from pyident.logs.log import Log
from pyident.regression.loads.bodies import link_torques
from pyident.simulation.denoised import denoised_equations

ROBOT = six_axes().with_settings(processing=Processing())
PERIOD, DURATION, NOISE = 0.004, 12.0, 0.005  # s, s, of a joint's rms torque
CHANCE = 4.0
ROTOR = 1.5  # kg m2, of the first two joints the larger part


def logged(coefficients):
    """A log under friction of `coefficients` by joint, and the loads that its transmissions carry."""
    rng = np.random.default_rng(5)
    time = np.arange(0, DURATION, PERIOD)
    w = 2 * np.pi * rng.uniform(0.1, 0.7, (6, 4))
    a, phase = rng.uniform(0.1, 0.3, (6, 4)), rng.uniform(0, 6, (6, 4))
    angle = w[None] * time[:, None, None] + phase
    q, v = (a * np.sin(angle)).sum(axis=2), (a * w * np.cos(angle)).sum(axis=2)
    dv = -(a * w**2 * np.sin(angle)).sum(axis=2)
    loads = inverse_dynamics(chain(ROBOT), q, v, dv)
    level = loads.std(axis=0) + 1.0
    tau = loads + ROTOR * dv + 0.2 * level * np.sign(v) + 0.1 * level * v
    for joint, coefficient in coefficients.items():
        tau[:, joint - 1] += coefficient * np.abs(loads[:, joint - 1]) * np.sign(v[:, joint - 1])
    tau += rng.normal(0, NOISE, tau.shape) * level
    columns = {f"joint{k + 1}.e": q[:, k] for k in range(6)} | {
        f"joint{k + 1}.tau": tau[:, k] for k in range(6)
    }
    return Log(pd.DataFrame({"time": time, **columns}), "made"), NOISE * level


def carried(coefficients):
    """The fitted robot before and after, and the log's motion."""
    log, noise = logged(coefficients)
    plain = denoised_equations(ROBOT, [log])
    levels = [np.repeat(noise[:, None], plain[0].y.shape[1], axis=1)]
    whitened = [e.over(level) for e, level in zip(plain, levels, strict=True)]
    base = solve_base(whitened)
    fitted = ROBOT.with_parameters(dict(zip(ROBOT.linear_parameters, base.p.tolist(), strict=True)))
    return fitted, with_carried_loads(fitted, whitened, base, levels, CHANCE), plain[0].part.motion


def off(robot, motion, joint):
    """Error of a load over its own size."""
    true = inverse_dynamics(chain(ROBOT), motion.q, motion.dq, motion.ddq)[:, joint - 1]
    return np.std(link_torques(robot, motion)[:, joint - 1] - true) / np.std(true)


@pytest.mark.parametrize("joint", [1, 2])
def test_friction_tells_the_load_where_the_torque_leaves_rotor_and_link_open(joint):
    before, after, motion = carried({joint: 0.15})
    assert off(before, motion, joint) > 0.1
    assert off(after, motion, joint) < 0.03


def test_each_joint_keeps_what_the_others_tell():
    _, after, motion = carried({1: 0.15, 2: 0.15})
    assert max(off(after, motion, 1), off(after, motion, 2)) < 0.05


def test_strong_friction_bends_the_bodies_until_the_load_has_another_sign():
    """The torque's sign is nearer the load's then than that of the bodies found."""
    before, after, motion = carried({2: 0.5, 3: 0.5})
    for joint, least in ((2, 0.2), (3, 0.05)):
        assert off(before, motion, joint) > least
        assert off(after, motion, joint) < 0.01


def test_a_joint_that_tells_nothing_is_left_as_it_was():
    before, after, motion = carried({3: 0.5})
    assert off(after, motion, 3) < 0.01
    assert off(after, motion, 2) < 2 * off(before, motion, 2)


def test_without_such_friction_nothing_moves():
    before, after, _ = carried({})
    assert after is before


def test_a_single_axis_tells_its_inertia_beside_a_weight_that_never_turns_round():
    """Closed form: the right bodies take a sixth more than those found without friction."""
    robot = one_joint()
    joint = replace(robot.joints[0], x=(0.0, 1.0, 0.0), y=(0.0, 0.0, 1.0))
    robot = replace(robot, joints=(joint,), controller=None).with_settings(processing=Processing())
    log = analytic_log(torque_noise=NOISE)
    time = log.frame["time"].to_numpy()
    q = log.frame["joint1.e"].to_numpy()
    v, dv = np.gradient(q, time), np.gradient(np.gradient(q, time), time)
    load = 0.35 * dv - 12.0 * np.cos(q)
    level = 1.5
    tau = load + 0.07 * dv + 2.0 * np.sign(v) + 1.5 * v + 0.2 * np.abs(load) * np.sign(v)
    noise = np.random.default_rng(1).normal(0, level, len(q))
    log = replace(log, frame=log.frame.assign(**{"joint1.tau": tau + noise}))
    plain = denoised_equations(robot, [log])
    levels = [np.full_like(plain[0].y, level)]
    whitened = [e.over(at) for e, at in zip(plain, levels, strict=True)]
    base = solve_base(whitened)
    fitted = robot.with_parameters(dict(zip(robot.linear_parameters, base.p.tolist(), strict=True)))
    found = with_carried_loads(fitted, whitened, base, levels, CHANCE)
    at = plain[0].part.motion
    true = 0.35 * at.ddq[:, 0] - 12.0 * np.cos(at.q[:, 0])
    assert np.std(link_torques(fitted, at)[:, 0] - true) > 0.3 * np.std(true)
    assert np.std(link_torques(found, at)[:, 0] - true) < 0.06 * np.std(true)
