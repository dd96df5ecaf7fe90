"""The studies of measured robots meet the published figures."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from flexmodels.files.robot_file import load_robot
from pyident.checks.check_log import check_log
from pyident.checks.encoder_delay import encoder_skews, without_skew
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import weighted
from pyident.logs.datasets import fetch, shipped_mapping
from pyident.logs.foreign import import_log
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.simulation.replica import repeats
from pyident.sweep.studies import find_study


@pytest.mark.parametrize(("name", "goals"), [("tx40", 4), ("kuka_kr300", 2)])
def test_published_figures(name, goals, data, tmp_path):
    run = find_study(name)
    assert run is not None
    result = run(tmp_path, lambda _: None)
    judged = [r for r in result.rows if r["met"] != "-"]
    assert (len(judged), {r["met"] for r in judged}) == (goals, {"yes"})
    assert (tmp_path / "index.html").is_file()
    if name == "kuka_kr300":
        stiffness = [r["value"] for r in result.rows if r["what"].endswith("stiffness, MN m/rad")]
        assert stiffness[0].startswith("not identifiable")
        assert all("authors" in text for text in stiffness[1:])


def test_regression_of_all_equations_leaves_the_kuka_its_stiffness(data):
    robot = load_robot("kuka_kr300")
    run_a = import_log([fetch("kuka_kr300", download=False)[0]], shipped_mapping("kuka_kr300"), robot)
    late = [replace(skew, delay=0.003) for skew in encoder_skews(robot, run_a)]
    log, _ = without_skew(run_a, [replace(skew, std=1e-5) for skew in late])
    found = weighted(Problem(robot, (condition(log, robot),)))
    stiffness = found.solution.p[[found.reduced.columns.index(f"joint{k}.k[1]") for k in (2, 3)]]
    assert (stiffness > 1e6).all()  # [N m/rad]
    assert (stiffness < 8e6).all()


def test_twist_only_joints_have_the_right_signs(data):
    robot = load_robot("kuka_kr300")
    run_a = import_log([fetch("kuka_kr300", download=False)[0]], shipped_mapping("kuka_kr300"), robot)
    assert check_log(robot, run_a) == ()


@pytest.fixture
def swing():
    """A log of the TX40 whose axes move and stand in turn."""
    time = np.arange(20_000) / 5000
    angle = np.clip(np.sin(2 * np.pi * time), -0.5, 0.5)
    columns = {f"joint{k}.e": angle for k in range(1, 7)} | {f"joint{k}.tau": 0 * time for k in range(1, 7)}
    return Log(pd.DataFrame({"time": time} | columns), "swing")


def test_thinned_equations_at_rest_are_left_out(swing):
    robot = load_robot("tx40")
    part = condition(swing, robot)
    standing = np.abs(part.motion.dq[:, 0]) < robot.settings.processing.dead_zone
    assert 0.5 < standing.mean() < 0.75
    assert np.array_equal(part.use[:, 0], 1.0 - standing)
    ((A, y),) = Problem(robot, (part,)).blocks()
    kept = standing[::100]
    assert not A[kept].any()
    assert A[~kept, 0].any(axis=1).all()
    assert len(y) == len(kept)


def test_a_motion_is_repeated_by_a_robot_with_nonlinear_parameters(swing):
    robot, (plan,) = repeats(load_robot("tx40"), [swing])
    assert robot.controller is not None
    assert plan.plan.reference.shape == (20_000, 6)


def test_shipped_robots_hold_their_transmissions():
    assert load_robot("tx40").transmission.ratio[5][4] == 32.0  # pyright: ignore[reportOptionalMemberAccess]
    assert load_robot("kuka_kr300").coordinates[6:] == tuple(f"joint{k}.eps[1]" for k in (1, 2, 3))
