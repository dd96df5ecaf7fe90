"""What a model's equations leave of a log, from the closed form of one joint."""

import numpy as np
import pytest
from analytic_joint import INERTIA, analytic_log, free_joint

from pyident.comparison.model_against_replicas import judged_logs, residual
from pyident.comparison.trial import on_trial
from pyident.conditioning.weak_form import condition
from pyident.simulation.fmu_runs import runs_here


def test_the_true_model_leaves_the_noise_of_its_torque():
    robot = free_joint()
    part = condition(analytic_log(torque_noise=0.2), robot)
    left = residual(robot, part)
    used = part.use[:, 0] > 0
    assert np.std(left[used, 0]) == pytest.approx(0.2, rel=0.05)
    assert not left[~used].any()


def test_a_wrong_inertia_leaves_its_share_of_the_acceleration():
    robot = free_joint()
    part = condition(analytic_log(), robot)
    heavier = robot.with_parameters({"joint1.J_m": robot.parameters["joint1.J_m"] + 0.1 * INERTIA})
    left = residual(heavier, part)
    expected = -0.1 * INERTIA * part.motion.ddq * part.use
    assert left == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())


def test_a_model_without_controller_is_tracked_by_a_stand_in():
    robot = free_joint()
    trial = on_trial(robot, [analytic_log(torque_noise=0.2)])
    assert trial.tracks
    assert trial.simulated.controller is not None
    assert trial.since == (0.0,)
    assert trial.noise["joint1.tau"] == pytest.approx(0.2, rel=0.15)


def test_torques_count_where_their_equations_are_used():
    """Where the joint turns round, the friction of a simulation that tracks it comes late."""
    trial = on_trial(free_joint(), [analytic_log(torque_noise=0.02)])
    with runs_here(trial.simulated) as workers:
        (part,) = judged_logs(trial, workers)
    counted = part.counted["joint1.tau"]
    assert part.missed_where_counted("joint1.tau").shape == (counted.sum(),)
    assert 0.8 < counted.mean() < 1
    angle = trial.judged[0].log.frame["joint1.e"].to_numpy()[-len(counted) :]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(angle)))) + 1
    assert len(turns) > 10
    assert not counted[turns].any()
    assert len(part.missed_where_counted("joint1.e")) == len(counted)
