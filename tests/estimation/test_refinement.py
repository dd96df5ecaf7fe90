"""Bias and noise: indirect inference, output error, robust and coloured-residual estimation."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodels.experiment import identification
from pyident.conditioning.weak_form import condition
from pyident.estimation.base_parameters import weakest_directions
from pyident.estimation.estimator import reweighted, weighted
from pyident.estimation.identify import identify
from pyident.logs.log import Log, LogError
from pyident.refinement.output_error import output_error
from pyident.refinement.remove_bias import correct_by_replicas
from pyident.regression.equations import Problem
from pyident.simulation.fmu_runs import FmuRuns
from pyident.simulation.replay import replay_of


@pytest.fixture(scope="module")
def runs(four_link):
    with FmuRuns(four_link) as runs:
        yield runs


def test_runs_come_back_in_their_order(four_link, runs):
    plan = identification(four_link, duration=0.2)
    frames = list(runs(plan, [{"joint1.coulomb": c} for c in (0.0, 200.0, 0.0)]))
    assert frames[0].equals(frames[2])
    assert not frames[0].equals(frames[1])


def test_replicas_remove_the_regressions_bias(four_link, identification_log, runs):
    """Noise-free, held torque: goals 0.5 % (drives), 1 % (bendings, motor inertias), 2 % (friction)."""
    found = correct_by_replicas(four_link, [identification_log], runs)
    goals = {"k[1]": 0.5, "k[2]": 1.0, "k[3]": 1.0, "J_m": 1.0, "coulomb": 2.0, "viscous": 2.0}
    checked = 0
    for i, (name, true) in enumerate(four_link.parameters.items()):
        goal = goals.get(name.split(".")[1])
        if goal and found.support[name] == "alone":
            assert 100 * abs(found.solution.p[i] / true - 1) < goal / 10, name
            checked += 1
    assert checked == 22


def test_the_regression_alone_leaves_less_than_a_percent(four_link, identification_log):
    found = identify(four_link, [identification_log])
    assert max(found.relative_error.values()) < 1.0
    assert "link1.ms[z], joint1.k[2] and joint1.k[3] act together" in "\n".join(
        weakest_directions(found.reduced, found.solution)
    )


def test_output_error_needs_the_reference(four_link, identification_log):
    bare = Log(identification_log.frame.drop(columns="joint3.r"), "bare")
    with pytest.raises(LogError, match=r"column joint3\.r is missing, the reference"):
        replay_of(four_link, bare)


@pytest.mark.slow
def test_output_error_finds_the_noise_level_and_covers_the_truth(four_link, identification_log, runs):
    """A short noisy log: what is left is the noise that was put in, and the intervals hold."""
    rng = np.random.default_rng(4)
    frame = identification_log.frame.head(1100).copy()
    for name in frame:
        if name.endswith(".e") or ".eps" in name:
            frame[name] += (2e-6 if name.endswith(".e") else 1e-6) * rng.standard_normal(len(frame))
        elif name.endswith(".tau"):
            frame[name] += 0.002 * frame[name].abs().max() * rng.standard_normal(len(frame))
    log = Log(frame, "noisy")
    start = correct_by_replicas(four_link, [log], runs)
    refined = output_error(four_link, [log], start, runs)
    replay = replay_of(four_link, log)
    left = replay.missed(next(iter(runs(replay.plan, [refined.robot.parameters]))))
    np.testing.assert_allclose(left[:, :4].std(axis=0), 2e-6, rtol=0.1)
    np.testing.assert_allclose(left[:, 4:16].std(axis=0), 1e-6, rtol=0.15)
    true = np.array(list(four_link.parameters.values()))
    alone = ~refined.solution.open
    z = (refined.solution.p - true)[alone] / refined.solution.std[alone]
    assert np.mean(np.abs(z) < 1.96) > 0.85


def test_robust_estimation_shrugs_off_outliers(four_link, identification_log):
    frame = identification_log.frame.head(2000).copy()
    rng = np.random.default_rng(5)
    hit = rng.choice(len(frame), 25, replace=False)
    against_motion = np.sign(np.gradient(frame["joint2.e"].to_numpy()))[hit]  # as more friction would be
    frame.loc[hit, "joint2.tau"] += 300.0 * against_motion
    log = Log(frame, "outliers")
    true = four_link.parameters["joint2.coulomb"]
    errors = [
        abs(identify(four_link, [log], estimator).robot.parameters["joint2.coulomb"] / true - 1)
        for estimator in (weighted, reweighted)
    ]
    assert errors[1] < errors[0] / 5
    assert errors[1] < 0.01


def test_covariance_knows_of_coloured_residuals(four_link, identification_log):
    """A law left out of the model: the residual is slow, and white-noise intervals are too narrow."""
    log = Log(identification_log.frame.head(2000), "short")
    joints = tuple(
        replace(joint, values={name: v for name, v in joint.values.items() if name != "viscous"})
        for joint in four_link.joints
    )
    robot = replace(four_link, joints=joints)
    found = weighted(Problem(robot, (condition(log, robot),)))
    white, coloured = found.solution, found.with_long_memory().solution
    ratio = coloured.std[~coloured.open] / white.std[~white.open]
    assert np.median(ratio) > 1.3
    names = [n for n, hidden in zip(robot.parameters, coloured.open, strict=True) if not hidden]
    assert ratio[names.index("joint1.coulomb")] > 2
