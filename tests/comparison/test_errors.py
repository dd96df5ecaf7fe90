"""Errors beside signal and floor, and what a format costs that cannot hold a law: from their definitions."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint
from servo_pendulum import by_hand, pendulum

import pyident as pi
from flexmodels.experiment import Experiment
from pyident.comparison.errors import Error, LogErrors
from pyident.comparison.export_cost import cost_of_export
from pyident.comparison.fails import in_simulation
from pyident.logs.log import Log, LogError
from pyident.simulation.fmu_runs import FmuRuns

TURN = 2 * np.pi
FAIR, POOR = Error(0.1, 8.0, 0.1, "N m"), Error(2.0, 8.0, 0.1, "rad")


def test_an_error_is_read_against_signal_and_floor():
    error = Error(rmse=2.0, signal=8.0, floor=0.5, unit="N.m")
    assert (error.nrmse_percent, error.floor_percent, error.ratio) == (25.0, 6.25, 4.0)
    assert error.json() == {
        "rmse": 2.0,
        "unit": "N.m",
        "nrmse_percent": 25.0,
        "floor_percent": 6.25,
        "over_floor": 4.0,
    }


@pytest.mark.parametrize(
    ("missed", "words"),
    [(0.104, "N m rms, no more than the floor."), (0.11, "N m rms, 1.1 times the floor.")],
)
def test_an_error_at_its_floor_is_said_to_be_there(missed, words):
    """And where a loop stands in for the controller, positions are not what is judged."""
    errors = LogErrors(
        "a.csv", {}, {"joint1.e": POOR, "joint1.tau": replace(FAIR, rmse=missed)}, np.zeros(1), {}
    )
    trial: Any = SimpleNamespace(tracks=True, judged=[SimpleNamespace(note="it has no [controller]")])
    said = in_simulation(trial, [errors])
    assert said.startswith(f"In simulation joint 1's torque misses by {missed:g} {words}")
    assert said.endswith("that stands in for a controller, so judge by the torques.")
    calm = in_simulation(trial, [errors], True)
    assert calm.startswith("But in simulation" if missed > 0.105 else "In simulation")


def test_a_floor_that_hides_much_is_said_to():
    errors = LogErrors("a.csv", {}, {"joint1.tau": Error(0.5, 1.0, 0.6, "N.m")}, np.zeros(1), {})
    trial: Any = SimpleNamespace(tracks=True, judged=[])
    said = in_simulation(trial, [errors])
    assert said.endswith("0.5 N.m rms, no more than the floor, which hides much: 60 % of it.")


def test_motors_and_deformations_of_a_log_are_told_apart():
    error = Error(2.0, 8.0, 0.5, "N.m")
    log = LogErrors("a.csv", {"joint1.e": error, "joint1.eps[1]": error}, {}, np.zeros(1), {})
    told = log.json()
    assert set(told["torque"]) == {"joint1"}
    assert "joint1.eps[1]" in str(told)


def test_the_cost_of_a_lost_law_is_its_share_of_the_torque():
    """tau = J a + c sign(v) + d v: without viscous friction |d v| / |tau| is missed."""
    time = np.arange(2001) * 0.004
    reference = (1 - np.cos(TURN * time))[:, None]
    log = pi.simulate(one_joint(), Experiment(time, reference, np.zeros_like(reference)))
    cost = cost_of_export(one_joint(), log, frozenset({"motor_inertia", "coulomb"}), FmuRuns)
    e, tau = log.signals(["joint1.e", "joint1.tau"]).T
    v = np.gradient(e, log.period)
    assert cost.lost == ("viscous",)
    assert cost.all_laws < 2.0
    expected = 100 * np.linalg.norm(2.0 * v) / np.linalg.norm(tau)
    assert cost.kept == pytest.approx(expected, rel=0.05)
    assert cost.sentence.endswith("without viscous")
    whole = cost_of_export(one_joint(), log, frozenset({"motor_inertia", "coulomb", "viscous"}), FmuRuns)
    assert whole.sentence.startswith("nothing is lost: the torque error stays ")
    assert whole.kept == whole.all_laws


def test_without_torques_the_cost_is_told_by_the_position_in_closed_loop():
    """Against the same loop integrated by SciPy, with the law and without it."""
    time = np.arange(301) * 0.005
    reference = (0.7 * np.sin(2 * np.pi * time) + 0.2)[:, None]
    plan = Experiment(time, reference, 0 * reference, np.ones_like(reference), np.array([0.2]))
    robot = pendulum().with_parameters({"joint1.viscous": 0.05})
    e, without = by_hand(plan, viscous=0.05), by_hand(plan, viscous=0.0)
    log = Log(pd.DataFrame({"time": time, "joint1.r": reference[:, 0], "joint1.e": e}), "servo.csv")
    cost = cost_of_export(robot, log, frozenset({"motor_inertia"}), FmuRuns)
    assert cost.lost == ("viscous",)
    assert cost.all_laws < 0.1
    assert cost.kept == pytest.approx(100 * np.sqrt(np.mean((without - e) ** 2)) / e.std(), rel=0.02)
    assert cost.sentence.startswith("the position error in closed loop is ")
    with pytest.raises(LogError, match=r"servo\.csv: it has no torques and cannot be simulated"):
        cost_of_export(robot, Log(log.frame.drop(columns="joint1.r"), "servo.csv"), frozenset(), FmuRuns)
    driven = one_joint()
    with pytest.raises(LogError, match=r"servo\.csv: it has no torques, and joint1\.tau_ff is missing"):
        cost_of_export(driven, log, frozenset(), FmuRuns)
