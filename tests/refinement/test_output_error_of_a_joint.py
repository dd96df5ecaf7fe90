"""Output error in closed loop on one joint, whose parameters are known."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from one_joint import one_joint
from one_joint_logs import motion
from two_link_logs import loaded

import pyident as pi
from pyident.refinement.auxiliary_model import identify_by_instruments
from pyident.refinement.output_error import output_error
from pyident.simulation.fmu_runs import FmuRuns
from pyident.simulation.replica import Repeat

SIGMA = 2e-6  # rad, of the angle


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    robot, made = one_joint(), []
    with loaded(robot, tmp_path_factory.mktemp("fmu")) as fmu:
        for seed in (1, 2):
            plan = motion(seed)
            clean = Repeat(pi.Log(fmu.simulate(plan), f"log {seed}"), plan)
            made.append(clean.replica(fmu.simulate, robot.parameters, {"joint1.e": SIGMA}, seed))
    return made


@pytest.fixture(scope="module")
def start():
    """What a file that is 30 % off says."""
    return one_joint().with_parameters({n: 1.3 * v for n, v in one_joint().parameters.items()})


def test_the_robot_follows_its_logs_and_its_intervals_hold(start, logs):
    shares: list[float] = []
    fit = pi.refine(start, logs, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    for name, truth in (("joint1.coulomb", 1.0), ("joint1.viscous", 2.0)):
        row = fit.to_frame().loc[name]
        assert row["value"] == pytest.approx(truth, rel=2e-4)
        assert abs(row["value"] - truth) < 4 * row["std"]
    assert fit.to_dict()["estimator"] == "output error in closed loop"


def test_it_is_an_estimator_among_others_and_leaves_open_what_the_prior_says(start, logs):
    prior = one_joint().with_parameters({"link1.m": 3.0})
    plain, near = pi.refine(start, logs), pi.identify(start, logs, estimator="oe", prior=prior)
    assert near.robot.parameters["link1.m"] == pytest.approx(3.0, rel=1e-3)
    for name in ("joint1.coulomb", "joint1.viscous"):
        assert near.robot.parameters[name] == pytest.approx(plain.robot.parameters[name], rel=1e-6)


def test_without_a_known_loop_it_says_so(logs):
    bare = [replace(log, frame=log.frame.drop(columns="joint1.r")) for log in logs]
    with pytest.raises(pi.LogError, match=r"column joint1\.r"):
        pi.refine(one_joint(), bare)
    with pytest.raises(pi.RobotError, match=r"no \[controller\] and no \[servo\]"):
        pi.refine(replace(one_joint(), controller=None), logs)


def test_its_differences_are_as_long_as_the_logs_own_columns_ask(logs):
    """Instruments are filtered; a difference as long as theirs ask would leave the range of a slope."""
    robot = one_joint()
    with FmuRuns(robot) as simulate:
        found = identify_by_instruments(robot, logs, lambda _: nullcontext(simulate))
        solution = found.solution
        faint = np.where(np.array(found.reduced.columns) == "joint1.viscous", 1e-7, 1.0)
        filtered = replace(found, solution=replace(solution, scale=solution.scale * faint))
        plain, other = (output_error(robot, logs, f, simulate) for f in (found, filtered))
    std = plain.solution.std
    assert np.abs((other.solution.p - plain.solution.p) / std).max() < 0.1
    assert other.solution.std == pytest.approx(std, rel=0.01)
