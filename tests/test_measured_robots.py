"""The studies of measured robots meet the published figures."""

from dataclasses import replace

import pytest

from flexmodels.robot_file import load_robot
from pyident.conditioning import condition
from pyident.data import fetch, shipped_mapping
from pyident.estimate import estimate
from pyident.log_import import import_log
from pyident.problem import Problem
from pyident.skew import encoder_skews, without_skew
from pyident.studies import find_study


@pytest.mark.parametrize(("name", "goals"), [("tx40", 4), ("kuka_kr300", 2)])
def test_published_figures(name, goals, data, tmp_path):
    run = find_study(name)
    assert run is not None
    result = run(tmp_path, lambda _: None)
    judged = [r for r in result.rows if r["met"] != "-"]
    assert (len(judged), {r["met"] for r in judged}) == (goals, {"yes"})
    assert (tmp_path / "index.html").is_file()
    if name == "kuka_kr300":
        stiffness = [r["value"] for r in result.rows if r["what"].endswith("stiffness")]
        assert stiffness[0].startswith("not identifiable")
        assert all("MN m/rad" in text for text in stiffness[1:])


def test_regression_of_all_equations_leaves_the_kuka_its_stiffness(data):
    robot = load_robot("kuka_kr300")
    run_a = import_log([fetch("kuka_kr300", download=False)[0]], shipped_mapping("kuka_kr300"), robot)
    late = [replace(skew, delay=0.003) for skew in encoder_skews(robot, run_a)]
    log, _ = without_skew(run_a, [replace(skew, std=1e-5) for skew in late])
    reduced, found = estimate(Problem(robot, (condition(log, robot),)))
    stiffness = found.p[[reduced.columns.index(f"joint{k}.k[1]") for k in (2, 3)]]
    assert (stiffness > 1e6).all()  # [N m/rad]
    assert (stiffness < 8e6).all()


def test_shipped_robots_hold_their_transmissions():
    assert load_robot("tx40").transmission.ratio[5][4] == 32.0  # pyright: ignore[reportOptionalMemberAccess]
    assert load_robot("kuka_kr300").coordinates[6:] == tuple(f"joint{k}.eps[1]" for k in (1, 2, 3))
