"""Equations without the noise of encoders: what they predict of another motion."""

from dataclasses import replace

import numpy as np
from six_axis_logs import arm, made, plain

from flexmodels.files.robot_file import load_robot
from pyident.conditioning.fading import fading
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import weighted
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.regression.regressor import generalised_forces
from pyident.simulation.denoised import denoised, denoised_equations, denoised_every_sample, unfiltered

STEP = 2 * np.pi / 2**14


def coarse(log: Log) -> Log:
    """As an encoder of 14 bit has it."""
    frame = log.frame.copy()
    names = [name for name in frame if str(name).endswith(".e")]
    frame[names] = np.round(frame[names] / STEP) * STEP
    return replace(log, frame=frame)


def test_a_fit_predicts_the_torques_of_another_motion():
    """By its regressor's noise a plain fit is off by several times the torques' noise, which is 0.4 %."""
    robot = arm()
    log, other = coarse(made(robot, 0, plain, 20.0)), made(robot, 5, plain, 20.0)
    clean = denoised(robot, other)  # its encoders are a hundred times finer
    error = {}
    for name, part in (("plain", condition(log, robot)), ("denoised", denoised(robot, log))):
        p = weighted(Problem(robot, (part,))).solution.p
        missed = (clean.target - generalised_forces(robot, clean.motion, p)) * clean.use
        error[name] = np.sqrt(np.mean(missed**2, axis=0) / np.mean(clean.target**2, axis=0))
    assert (error["denoised"] < 0.015).all()
    assert np.mean(error["plain"]) > 3 * np.mean(error["denoised"])


def test_springs_leave_the_motion_as_it_is():
    log, robot = coarse(made(arm(), 0, plain, 20.0)), load_robot("four_link")
    names = [*robot.coordinates, *robot.torques]
    columns = {name: log.frame["joint1.e" if ".tau" not in name else "joint1.tau"] for name in names}
    log = replace(log, frame=log.frame[["time"]].assign(**columns))
    assert np.array_equal(denoised(robot, log).motion.q, condition(log, robot).motion.q)
    assert np.array_equal(denoised_every_sample(robot, log).use, fading(condition(log, robot).use))


def test_without_its_filter_a_robot_is_judged_as_far_as_with_it():
    log = made(arm(), 0, plain, 20.0)
    for cutoff, decimate, top in ((5.0, 1, 4.0), (40.0, 5, 8.0), (45.0, 1, 30.0)):
        plan = replace(arm().settings.processing, cutoff=cutoff, decimate=decimate)
        filtered = arm().with_settings(processing=plan)
        robot = unfiltered(filtered, [log])
        assert robot.settings.processing.cutoff is None
        bands = [denoised_equations(each, [log])[0].band.frequencies[-1] for each in (filtered, robot)]
        assert np.allclose(bands, top, atol=0.3)
        assert np.array_equal(denoised(robot, log).motion.ddq, denoised(arm(), log).motion.ddq)
    assert unfiltered(arm(), [log]) == arm()
