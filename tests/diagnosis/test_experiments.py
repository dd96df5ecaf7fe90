"""Rivals whose separating motion is known from physics."""

from dataclasses import replace

import numpy as np
import pytest
from one_joint import one_joint

from flexmodels.robot import Robot, RobotError
from flexmodels.settings.motions import Identification, Multisine
from pyident.diagnosis.motions.separating import Separation, distance, separating
from pyident.estimation.identify import identify
from pyident.excitation.variants import variants
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import runs_here
from pyident.simulation.simulator import rivals as simulated

NOISE = {"joint1.e": 2e-6}


def arm() -> Robot:
    plan = Identification((1.0,), 2.0, 16.0, Multisine((1.0,), 40, 0.5, 30.0))
    return one_joint().with_settings(identification=plan)


def having(effect: str, **values: float) -> Robot:
    robot = arm().with_effect(1, effect)
    return robot.with_parameters({f"joint1.{effect}.{name}": value for name, value in values.items()})


def found(*rivals: Robot) -> tuple[Separation, dict[str, list[Log]]]:
    logs: dict[str, list[Log]] = {}
    plans = variants(arm(), duration=4.0)
    with simulated(runs_here, rivals) as runs:
        frames = {name: runs(plan) for name, plan in plans.items()}
    for name, each in frames.items():
        logs[name] = [Log(frame, name) for frame in each]
    order = iter(frames.values())
    return separating(rivals, plans, lambda _: next(order), NOISE), logs


def test_variants_stay_within_the_experiment():
    plans = variants(arm(), duration=4.0)
    whole = plans["the identification experiment"]
    speed = np.abs(np.diff(whole.reference, axis=0)).max()
    for name, plan in plans.items():
        assert np.ptp(plan.reference) <= np.ptp(whole.reference) * (1 + 1e-9), name
        assert np.abs(np.diff(plan.reference, axis=0)).max() <= speed * (1 + 1e-9), name
        assert plan.time[-1] == pytest.approx(4.0)
    assert not plans["the identification experiment without its multisine"].feedforward.any()


def test_each_joint_of_several_moves_alone(four_link):
    plan = variants(four_link)["the identification experiment with joint 3 alone"]
    assert np.ptp(plan.reference, axis=0)[2] > 1
    assert (np.ptp(plan.reference, axis=0)[[0, 1, 3]] == 0).all()
    assert not plan.feedforward[:, [0, 1, 3]].any()


def test_a_robot_without_an_experiment_takes_the_logs():
    robot = arm()
    with simulated(runs_here, [robot]) as runs:
        log = Log(runs(variants(robot, duration=4.0)["the identification experiment"])[0], "own.csv")
    plans = variants(robot.with_settings(identification=None), log, duration=2.0)
    assert plans["the motion of own.csv at half the speed"].reference[-1] == pytest.approx(
        log.frame["joint1.r"].iloc[250]
    )
    with pytest.raises(RobotError, match="no log was given"):
        variants(robot.with_settings(identification=None))


def test_what_a_refit_takes_does_not_count():
    other = arm().with_parameters({"joint1.coulomb": 1.5, "joint1.viscous": 2.4, "joint1.J_m": 0.7})
    separation, _ = found(arm(), other)
    assert separation.score < 1e-3
    assert separation.sentence == "none of the motions tried would separate them"


def test_a_slow_current_loop_shows_the_better_the_larger_the_multisine():
    separation, _ = found(arm(), having("torque_delay", share=1.0, delay=0.002))
    whole = "the identification experiment"
    names = [
        f"{whole} without its multisine",
        f"{whole} with a multisine 0.5 times as large",
        whole,
        f"{whole} with a multisine 1.5 times as large",
    ]
    scores = [separation.scores[name] for name in names]
    assert scores == sorted(scores)
    assert scores[-1] > 2 * scores[0]


def test_the_best_motion_determines_the_effect_best():
    """Oracle: the standard deviation that a regression of noisy logs gives the effect's level."""
    hidden = having("stribeck", level=0.5, velocity=0.03)
    separation, logs = found(arm(), hidden)
    std = {}
    for name, (_, log) in logs.items():
        rng, frame = np.random.default_rng(1), log.frame.copy()
        frame["joint1.e"] += NOISE["joint1.e"] * rng.standard_normal(len(frame))
        at = list(hidden.linear_parameters).index("joint1.stribeck.level")
        std[name] = float(identify(hidden, [replace(log, frame=frame)]).solution.std[at])
    assert separation.name == "the identification experiment at a quarter of the speed"
    assert min(std, key=lambda name: std[name]) == separation.name
    assert std["the identification experiment"] > 5 * std[separation.name]


def test_distance_to_itself_is_nothing():
    robot = having("stribeck", level=0.5, velocity=0.03)
    with simulated(runs_here, [robot]) as runs:
        log = Log(runs(variants(robot, duration=2.0)["the identification experiment"])[0], "log")
    assert distance(robot, robot, log, NOISE) == pytest.approx(0, abs=1e-6)
