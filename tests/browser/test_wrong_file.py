"""A robot file whose upper arm is 6 mm short: named, corrected by a click, still known after a restart."""

import pytest
from six_axis_logs import arm, made
from steps import PATIENCE, checked, pictured, served

from flexmodels.files.robot_file import load_robot, save_robot
from pyident.logs.log import write_log
from pyident.regression.descriptions import corrected

pytestmark = pytest.mark.browser
SHORT = 0.006  # m
DURATION, PACE = 20.0, 6.0  # s; a slow arm feels gravity alone, and that a link's mass explains as well


@pytest.fixture
def project(tmp_path):
    robot = arm()
    save_robot(robot, tmp_path / "robot.toml")
    longer = corrected(robot, 3, "origin[x]", SHORT)
    for seed, name in enumerate("abc"):
        write_log(made(longer, seed, duration=DURATION, pace=PACE), tmp_path / f"{name}.parquet")
    return tmp_path


def test_a_wrong_robot_file_is_corrected_by_a_click(tab, project):
    with served(project) as url:
        checked(tab, url)
        tab.get_by_test_id("place-where").click()
        tab.get_by_test_id("compare").click()
        tab.get_by_test_id("not-simulated").wait_for(timeout=PATIENCE)  # as its inertias are nominal
        assert tab.get_by_test_id("message").count() == 0
        tab.get_by_test_id("place-why").click()
        assert "identify it in place 2" in tab.get_by_test_id("no-ranking").inner_text()
        tab.get_by_test_id("diagnose").click()
        tab.get_by_test_id("sentence").wait_for(timeout=PATIENCE)
        assert tab.get_by_test_id("verdict").inner_text() == "the robot file is wrong"
        assert "origin[x] at joint3 of the robot file" in tab.get_by_test_id("finding-1").inner_text()
        assert tab.get_by_test_id("add-1-1").inner_text() == "Correct it"
        pictured(tab, "wrong_file")
        tab.get_by_test_id("add-1-1").click()
        tab.get_by_test_id("version-1").wait_for(timeout=PATIENCE)
        assert tab.get_by_test_id("outcome").inner_text() == "accepted"
        pictured(tab, "corrected")
    before, after = (load_robot(project / f) for f in ("robot.toml", "with_geometry_3.toml"))
    moved = after.joints[2].origin[0] - before.joints[2].origin[0]
    assert moved == pytest.approx(SHORT, rel=0.1)
    with served(project) as url:
        tab.goto(url + "&place=why")
        assert tab.get_by_test_id("version-1").inner_text() == "origin[x] at joint 3"
        assert tab.get_by_test_id("outcome").inner_text() == "accepted"
        tab.get_by_test_id("undo").click()
        tab.get_by_test_id("undo").wait_for(state="detached")
        assert tab.get_by_test_id("verdict").inner_text() == "the robot file is wrong"
        assert tab.get_by_test_id("sentence").inner_text().startswith("Wrong: joint3.origin[x]")
        assert tab.errors == []
