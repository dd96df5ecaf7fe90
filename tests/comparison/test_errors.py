"""Errors beside signal and floor, and what a format costs that cannot hold a law: from their definitions."""

import numpy as np
import pytest
from one_joint import one_joint

import pyident as pi
from flexmodels.experiment import Experiment
from pyident.comparison.errors import Error, LogErrors
from pyident.comparison.export_cost import cost_of_export

TURN = 2 * np.pi


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
    cost = cost_of_export(one_joint(), log, frozenset({"motor_inertia", "coulomb"}))
    e, tau = log.signals(["joint1.e", "joint1.tau"]).T
    v = np.gradient(e, log.period)
    assert cost.lost == ("viscous",)
    assert cost.all_laws < 2.0
    expected = 100 * np.linalg.norm(2.0 * v) / np.linalg.norm(tau)
    assert cost.kept == pytest.approx(expected, rel=0.05)
    assert cost.sentence.endswith("without viscous")
    whole = cost_of_export(one_joint(), log, frozenset({"motor_inertia", "coulomb", "viscous"}))
    assert whole.sentence.startswith("nothing is lost: the torque error stays ")
    assert whole.kept == whole.all_laws
