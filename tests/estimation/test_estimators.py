"""Estimators on a joint whose torque has a closed form, and that replicas are estimated as their log was."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import COULOMB, VISCOUS, analytic_log, free_joint

from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.setting import set_up, unbiased
from pyident.estimation.estimator import ordinary, predicting, reweighted, total, weighted
from pyident.estimation.identify import identified
from pyident.logs.log import Log, LogError
from pyident.regression.equations import Problem
from pyident.simulation.processes.tools import inline
from pyident.simulation.simulator import Unsimulated


def problem(robot: Robot, log: Log) -> Problem:
    return Problem(robot, (condition(log, robot),))


def friction(robot: Robot, found) -> np.ndarray:
    names = ("joint1.viscous", "joint1.coulomb")
    return found.solution.p[[found.reduced.columns.index(n) for n in names]]


@pytest.mark.parametrize("estimator", [ordinary, weighted, reweighted, predicting, total])
def test_without_noise_each_finds_the_closed_form(estimator):
    found = estimator(problem(free_joint(), analytic_log()))
    assert friction(free_joint(), found) == pytest.approx([VISCOUS, COULOMB], rel=2e-3)


def test_errors_in_the_columns_shrink_least_squares_and_not_total_least_squares():
    """A column of noise alone: total least squares moves values away from zero, least squares towards it."""
    asked = problem(free_joint(), analytic_log(angle_noise=2e-3, torque_noise=0.05))
    plain, both = friction(free_joint(), weighted(asked)), friction(free_joint(), total(asked))
    assert (np.abs(both) >= np.abs(plain)).all()


def test_weights_of_the_log_are_those_of_its_replica():
    asked = problem(free_joint(), analytic_log(torque_noise=0.2))
    of_log = weighted(asked).solution
    again = weighted(asked, replace(of_log, weights=3 * of_log.weights)).solution
    assert (again.weights == 3 * of_log.weights).all()
    assert again.p == pytest.approx(of_log.p)


@pytest.mark.parametrize("estimator", [weighted, reweighted])
def test_replicas_are_estimated_as_the_log_was(estimator):
    asked = []

    def watched(problem, like=None):
        asked.append(like)
        return estimator(problem, like)

    log = analytic_log(torque_noise=0.1)
    setting = set_up(free_joint(), [log], estimator=watched)
    with inline(lambda: nullcontext(Unsimulated())) as workers:
        found = unbiased(setting, workers, rounds=1, probes=2)
    assert [like is None for like in asked] == [True, False, False]
    assert all(like is setting.solution for like in asked[1:])
    assert found.robot.parameters["joint1.coulomb"] == pytest.approx(COULOMB, rel=0.02)


def test_a_robust_setting_is_not_moved_by_single_torques():
    log = analytic_log()
    frame = log.frame.copy()
    hit = np.random.default_rng(2).choice(len(frame), 60, replace=False)
    frame.loc[hit, "joint1.tau"] += 40.0 * np.sign(np.gradient(frame["joint1.e"].to_numpy()))[hit]
    settings = [set_up(free_joint(), [Log(frame, "hit")], estimator=e) for e in (weighted, reweighted)]
    errors = [abs(s.robot.parameters["joint1.coulomb"] - COULOMB) for s in settings]
    assert errors[1] < errors[0] / 10


def test_the_long_memory_of_residuals_widens_intervals():
    """A slow torque that no law describes, against the same power of white noise."""
    log = analytic_log(torque_noise=0.1)
    slow = log.frame.assign(**{"joint1.tau": log.frame["joint1.tau"] + 0.5 * np.sin(0.9 * log.frame["time"])})
    spread = []
    for given in (log, Log(slow, "slow")):
        found = weighted(problem(free_joint(), given))
        at = found.reduced.columns.index("joint1.viscous")
        spread.append(found.with_long_memory().solution.std[at] / found.solution.std[at])
    assert spread[1] > 2 * spread[0]


def test_the_model_written_holds_the_values_found():
    found = weighted(problem(free_joint(), analytic_log()))
    written = identified(free_joint(), found.reduced, found.solution).robot
    assert written.parameters["joint1.viscous"] == pytest.approx(VISCOUS, rel=2e-3)


def test_torques_that_are_all_zero_are_refused():
    log = analytic_log()
    still = replace(log, frame=log.frame.assign(**{"joint1.tau": 0.0}))
    with pytest.raises(LogError, match="all torques of these logs are zero"):
        weighted(problem(free_joint(), still))
