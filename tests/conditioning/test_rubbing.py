"""Dry friction of a shaft that two motors turn, whose sign is that of a sum of their speeds."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from sympy import sign

from flexmodels.effects import signals
from flexmodels.effects.effect import Effect, Parameter
from flexmodels.effects.rubbing import rubbing
from flexmodels.files.robot_file import load_robot
from flexmodels.settings.processing import Processing
from pyident.conditioning.motion import Motion
from pyident.conditioning.reversals.rubbing import rubs
from pyident.conditioning.weak_form import condition, condition_every_sample
from pyident.estimation.estimator import weighted
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.regression.regressor import generalised_forces

T = 0.005  # s
COULOMB, VISCOUS = 0.3, 0.225  # N m and N m s/rad, of the shaft
SUM = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]


@pytest.fixture(scope="module")
def arm():
    """Six axes whose last two motors share a shaft."""
    return load_robot("tx40").with_settings(processing=Processing())


@pytest.fixture(scope="module")
def slow(arm):
    """A minute at a fifth of a radian per second, with friction that is a step, and the sum of its speeds."""
    rng, t = np.random.default_rng(3), np.arange(0, 60, T)
    w = 2 * np.pi * 0.02 * np.arange(1, 13) * rng.uniform(0.95, 1.05, (6, 12))
    a, phase = 0.1 * rng.standard_normal((6, 12)) / w, w * t[:, None, None] + rng.uniform(0, 6, (6, 12))
    waves = (a * np.sin(phase), a * w * np.cos(phase), -a * w**2 * np.sin(phase))
    q, dq, ddq = (x.sum(axis=2) for x in waves)
    plain = arm.without_effect("joint_coupling")
    tau = generalised_forces(plain, Motion(q, dq, ddq), np.array(list(plain.linear_parameters.values())))
    together = dq[:, 4] + dq[:, 5]
    tau[:, 4:] += (COULOMB * np.sign(together) + VISCOUS * together)[:, None]
    tau += 0.005 * tau.std(axis=0) * rng.standard_normal(tau.shape)
    names = [*arm.coordinates, *arm.torques]
    frame = pd.DataFrame({"time": t, **dict(zip(names, np.hstack([q, tau]).T, strict=True))})
    return Log(frame, "slow"), together[4:-4]


def test_a_shared_shaft_stands_in_the_equations_of_both_its_motors(arm):
    found = {tuple(rub.shares.tolist()): rub.rows for rub in rubs(arm)}
    assert found[tuple(SUM)] == (4, 5)
    own = {shares.index(1.0): rows for shares, rows in found.items() if sum(shares) == 1.0}
    assert own == {k: (k,) for k in range(6)}


def test_a_sign_of_a_torque_or_of_a_product_is_no_rubbing():
    c = Parameter("c", "N.m")
    for argument in (signals.tau, signals.de * signals.beyond.de, signals.de + signals.e):
        assert not rubbing(Effect("odd", "", {signals.e: c.symbol * sign(argument)}, (c,), ""))
    slides = 2 * signals.de - signals.beyond.de
    found = rubbing(Effect("gear", "", {signals.e: c.symbol * sign(slides)}, (c,), ""))
    assert found == {signals.e: ({signals.de: 2, signals.beyond.de: -1},)}


def test_equations_near_the_reversals_of_a_sum_are_left_out(arm, slow):
    log, together = slow
    use = condition(log, arm).use
    turns = np.flatnonzero(together[1:] * together[:-1] < 0)
    assert len(turns) > 10
    assert not use[turns][:, 4:].any()
    assert not use[turns + 1][:, 4:].any()
    alone = condition(log, arm.without_effect("joint_coupling")).use
    assert (use[:, :4] == alone[:, :4]).all()
    assert use[:, 4:].mean() > 0.85
    assert (use[:, 4:] <= alone[:, 4:]).all()


def test_thinned_equations_lack_what_is_within_the_dead_zone_of_a_sum(arm, slow):
    log, _ = slow
    plan = Processing(cutoff=20.0, decimate=4, dead_zone=0.05)
    part = condition(log, arm.with_settings(processing=plan))
    slides = part.motion.dq[:, 4] + part.motion.dq[:, 5]
    assert not part.use[np.abs(slides) < 0.05][:, 4:].any()
    assert part.use[(np.abs(slides) > 0.05) & (np.abs(part.motion.dq) > 0.05).all(axis=1)].all()
    every = condition_every_sample(log, arm.with_settings(processing=replace(plan, dead_zone=0.0)))
    assert not every.use[np.flatnonzero(np.diff(np.sign(slides)))][:, 4:].any()


def test_a_sum_that_rests_while_its_joints_move_tells_nothing(arm, slow):
    log, _ = slow
    frame = log.frame.copy()
    frame["joint6.e"] = 1e-5 * np.random.default_rng(0).standard_normal(len(frame)) - frame["joint5.e"]
    use = condition(Log(frame, "opposite"), arm).use
    assert not use[:, 4:].any()
    assert use[:, 3].mean() > 0.9


def test_slow_motion_finds_the_friction_of_a_shaft(arm, slow):
    """The law rounds its sign over 0.01 rad/s: what lies near rest had hidden 8 % of the viscous one."""
    log, _ = slow
    found = weighted(Problem(arm, (condition(log, arm),)))
    p = dict(zip(found.reduced.columns, found.solution.p.tolist(), strict=True))
    assert p["joint5.joint_coupling.coulomb"] == pytest.approx(COULOMB, rel=0.01)
    assert p["joint5.joint_coupling.viscous"] == pytest.approx(VISCOUS, rel=0.01)
