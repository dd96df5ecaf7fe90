"""Hoses, cables and stops: torques over an angle that begin somewhere, in closed form."""

import numpy as np
import pytest
from analytic_joint import free_joint, logs_with

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.searched import searched
from pyident.simulation.fmu_runs import runs_here


def diagnosed(torque) -> Diagnosis:
    """Of two logs and a held-out one with a further torque f(q) [N m]."""
    logs = logs_with(lambda q, v, load: torque(q))
    return concluded(searched(free_joint(), logs[:2], runs_here), runs_here, logs[2:])


def named(found: Diagnosis) -> list[list[str]]:
    return [[n.effect for n in f.tie] for f in found.findings]


def test_a_hose_with_a_dead_zone_is_told_with_both_its_ends():
    found = diagnosed(lambda q: 3.0 * np.maximum(q - 0.4, 0) + 2.0 * np.minimum(q + 0.3, 0))
    assert named(found) == [["slack_spring"]]
    (law,) = found.findings[0].tie
    assert (law.values["start_below"], law.values["start_above"]) == pytest.approx((-0.3, 0.4), abs=0.02)
    assert law.values["stiffness_above"] == pytest.approx(3.0, rel=0.05)
    assert law.values["stiffness_below"] == pytest.approx(2.0, rel=0.05)


def test_a_rubber_stop_is_told_and_no_counterbalance():
    """Stiffer the further it is pressed, so that no law of the catalogue is exact."""
    found = diagnosed(lambda q: 12.0 * np.maximum(q - 0.5, 0) ** 1.5)
    assert named(found)[0][0] == "slack_spring"
    assert found.findings[0].tie[0].values["stiffness_below"] < 0.1


def test_a_spring_without_slack_is_not_only_one_with_slack():
    found = diagnosed(lambda q: 1.5 * (q - 0.2))
    assert "joint_spring" in named(found)[0]
