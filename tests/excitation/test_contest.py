"""Two explanations and what logs of either would decide: promises are kept, and refits are free."""

from contextlib import ExitStack, contextmanager
from dataclasses import replace

import numpy as np
import pytest
from planned_joint import limited

import pyident as pi
from flexmodels.robot import RobotError
from pyident.excitation.rehearsals.rehearsal import others_like, rehearsal
from pyident.excitation.separation.contest import Contest
from pyident.excitation.separation.rivals import Rivals, Suspect, having, suspect
from pyident.logs.log import Log
from pyident.simulation.replica import with_noise

NOISE = {"joint1.e": 1e-5}


@contextmanager
def contest_of(*pair: Suspect | None):
    """On a joint, and the motion of its own experiment."""
    robot = limited()
    with ExitStack() as stack:
        own = stack.enter_context(rehearsal(robot))
        plan = pi.excite(robot, duration=3.0, evaluations=2, floor=None).plan
        log = own.log(plan)
        robots = [robot if who is None else having(robot, who, log) for who in pair]
        theirs = [stack.enter_context(rehearsal(x)) for x in robots]
        yield Contest(Rivals(robot, (pair[0], pair[1]), (robots[0], robots[1])), theirs, NOISE), plan


def test_suspects_are_read_and_wrong_ones_refused():
    assert suspect("stribeck@2") == Suspect("stribeck", 2)
    assert suspect("backlash@3=1e-4") == Suspect("backlash", 3, 1e-4)
    both = suspect("stribeck@2=3.1,velocity=0.1")
    assert both == Suspect("stribeck", 2, 3.1, (("velocity", 0.1),))
    with pytest.raises(RobotError, match="a size is not zero"):
        suspect("stribeck@2=level=1e13")
    for wrong in ("backlash", "stribeck@2=,", "stribeck@2=3,4", "stribeck@2=level=3,level=4"):
        with pytest.raises(RobotError, match="EFFECT@JOINT"):
            suspect(wrong)


def test_logs_of_another_robot_differ_by_what_was_promised():
    """Noise that its encoders add sample by sample, and parameters 10 % off."""
    with contest_of(Suspect("stribeck", 1), Suspect("nonlinear_viscous", 1)) as (contest, plan):
        promise = contest.sigmas(plan, range(101, 109))
        falls = []
        for side, one in enumerate(contest.rehearsals):
            (other,) = others_like(one.robot, 1, seed=5, spread=0.1)
            law = {n: v for n, v in one.robot.parameters.items() if n.count(".") == 2}
            real = other.with_parameters(law)
            logs = []
            for seed in range(8):
                rng = np.random.default_rng(seed)
                added = {name: sigma * rng.standard_normal(len(plan.time)) for name, sigma in NOISE.items()}
                run = with_noise(lambda p, x=one, r=real: x.fmu.simulate(p, r.parameters), plan, added)
                logs.append(Log(run))
            robots = [r if i != side else real for i, r in enumerate(contest.rivals.robots)]
            off = replace(contest, rivals=replace(contest.rivals, robots=(robots[0], robots[1])))
            falls.append(np.mean(off.falls(side, logs)))
    assert promise > 5
    assert np.sqrt(min(falls)) == pytest.approx(promise, rel=0.2)


def test_a_law_too_small_to_be_seen_is_not_promised():
    with contest_of(Suspect("stribeck", 1, 1e-6), None) as (contest, plan):
        assert contest.sigmas(plan, range(8)) < 2


@pytest.mark.slow
def test_a_law_without_a_rival_is_told_by_its_estimate():
    """One coefficient of a linear law: the fall is the square of its value over its standard deviation."""
    with contest_of(Suspect("viscous_drift", 1), None) as (contest, plan):
        promise = contest.sigmas(plan, range(8))
        robot = contest.rivals.robots[0]
        logs = contest.rehearsals[0].noisy(plan, NOISE, range(100, 140))
        name = "joint1.viscous_drift.drift"
        found = [pi.identify(robot, log).to_frame().loc[name, "value"] for log in logs]
    assert promise == pytest.approx(robot.parameters[name] / np.std(found), rel=0.5)
