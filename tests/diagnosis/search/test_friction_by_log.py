"""A robot that warmed up between two logs has another friction in each; one that lacks a law has not."""

from functools import partial

import numpy as np
import pytest
from six_axis_logs import COULOMB, VISCOUS, arm, made, plain, three_laws

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.friction_by_log import friction_by_log
from pyident.diagnosis.searched import searched
from pyident.simulation.fmu_runs import runs_here


def warm(q, v, load, time, share: float):
    return share * plain(q, v, load, time)


@pytest.fixture(scope="module")
def warmed():
    robot = arm()
    logs = [made(robot, seed, partial(warm, share=s)) for seed, s in ((1, 1.0), (2, 0.85), (3, 0.8))]
    return searched(robot, logs[:2], runs_here), logs[2:]


def test_friction_that_differs_is_no_missing_law(warmed):
    search, heldout = warmed
    found = concluded(search, runs_here, heldout)
    assert found.verdict == "nothing_detectable"
    assert found.sentence.startswith("The friction of joints 1, 2, 3, 4, 5 and 6 differs from log to log.")
    assert any("temperature does that" in note for note in found.notes)


def test_by_how_much(warmed):
    by_log = friction_by_log(warmed[0])
    assert by_log is not None
    differences = by_log.differences(warmed[0])
    for k in range(1, 7):
        (second,) = differences[f"joint{k}.viscous"]
        assert second == pytest.approx(-0.15 * VISCOUS[k - 1], rel=0.15)


@pytest.mark.slow
def test_laws_go_first():
    """Sub-linear friction is another slope in a log of twice the speed; the law takes more."""
    robot = arm()
    logs = [made(robot, seed, three_laws, pace=pace) for seed, pace in ((1, 1.0), (2, 2.0), (3, 1.5))]
    found = concluded(searched(robot, logs[:2], runs_here), runs_here, logs[2:])
    named = {(n.effect, n.joint) for f in found.findings for n in f.tie}
    assert ("nonlinear_viscous", "joint1") in named
    assert "differs from log to log" not in found.sentence


@pytest.mark.slow
def test_rounded_friction_at_another_speed_is_no_warm_robot():
    """All logs have one friction, which is viscous where a joint creeps and dry where it runs."""

    def rounded(q, v, load, time):
        return 2 * COULOMB * np.tanh(v / 0.2) + VISCOUS * v

    robot = arm()
    logs = [made(robot, seed, rounded, pace=pace) for seed, pace in ((1, 0.5), (2, 4.0), (3, 4.0))]
    found = concluded(searched(robot, logs[:2], runs_here), runs_here, logs[2:])
    assert found.verdict != "nothing_detectable"
    assert "friction" not in found.sentence.partition(" from log to log")[0]


def test_one_log_has_nothing_to_differ_from():
    robot = arm()
    search = searched(robot, [made(robot, 1, partial(warm, share=1.0))], runs_here)
    assert friction_by_log(search) is None
    assert np.isfinite(search.over_floor).all()
