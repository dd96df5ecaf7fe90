"""What a person does with the workbench, done by a browser."""

import json

import pytest
from conftest import PATIENCE, served

from pyident.logs.log import read_log, write_log

pytestmark = pytest.mark.browser


def checked(tab, url: str) -> None:
    """Open the workbench and let it check the logs."""
    tab.goto(url)
    tab.get_by_test_id("check").click()
    tab.get_by_test_id("sound").wait_for(timeout=PATIENCE)


def test_a_hidden_law_is_found_and_added_by_clicks(tab, project):
    """Eight clicks: check, where, compare, a bump, why, diagnose, add, undo."""
    with served(project) as url:
        checked(tab, url)
        tab.get_by_test_id("place-where").click()
        tab.get_by_test_id("compare").click()
        tab.get_by_test_id("where-sentence").wait_for(timeout=PATIENCE)
        assert "joint 2, motor side" in tab.get_by_test_id("where-sentence").inner_text()
        tab.get_by_test_id("bump-1").click()
        tab.get_by_test_id("whole").wait_for()
        assert "from=" in tab.url
        tab.get_by_test_id("place-why").click()
        tab.get_by_test_id("diagnose").click()
        tab.get_by_test_id("sentence").wait_for(timeout=PATIENCE)
        assert tab.get_by_test_id("verdict").inner_text() == "an effect is missing"
        assert "asymmetric_coulomb at joint2" in tab.get_by_test_id("finding-1").inner_text()
        tab.get_by_test_id("add-1-1").click()
        tab.get_by_test_id("version-1").wait_for(timeout=PATIENCE)
        tab.get_by_test_id("undo").click()
        tab.get_by_test_id("undo").wait_for(state="detached")
        assert tab.errors == []
        assert tab.hosts == {"127.0.0.1"}
    diagnosis = json.loads((project / "results" / "diagnose_v0.json").read_text())
    assert diagnosis["findings"][0]["tie"][0]["effect"] == "asymmetric_coulomb"
    added = json.loads((project / "results" / "add_asymmetric_coulomb_2_v0.json").read_text())
    assert added["accepted"]
    assert (project / "with_asymmetric_coulomb_2.toml").is_file()


def test_a_bad_log_keeps_the_lock_and_says_why(tab, project):
    log = read_log(project / "a.parquet")
    torque = [n for n in log.frame if n.endswith(".tau")]
    log.frame[torque] = -log.frame[torque]
    write_log(log, project / "a.parquet")
    with served(project) as url:
        tab.goto(url)
        tab.get_by_test_id("check").click()
        tab.get_by_text("refused:").first.wait_for(timeout=PATIENCE)
        assert tab.get_by_test_id("place-where").is_disabled()
        tab.goto(url + "&place=where")
        tab.get_by_test_id("locked").wait_for()


def test_a_restart_and_a_second_tab_show_the_same(tab, browser, project):
    with served(project) as url:
        tab.goto(url)
        tab.get_by_test_id("role-1").get_by_text("hold out").click()
        other = browser.new_page()
        other.goto(url)
        other.get_by_test_id("role-1").wait_for()
        pressed = other.get_by_test_id("role-1").get_by_role("button", pressed=True)
        assert pressed.inner_text() == "hold out"
        other.close()
    assert json.loads((project / "workbench.json").read_text())["roles"] == {"b.parquet": "hold out"}
    with served(project) as url:
        tab.goto(url)
        pressed = tab.get_by_test_id("role-1").get_by_role("button", pressed=True)
        assert pressed.inner_text() == "hold out"


def test_strangers_are_refused(tab, project):
    with served(project) as url:
        answer = tab.goto(url.partition("?")[0])
        assert answer.status == 403


def test_the_robot_stands_in_3d(tab, project):
    with served(project) as url:
        tab.goto(url + "&place=model")
        tab.get_by_test_id("scene").locator("canvas").first.wait_for()
        tab.wait_for_timeout(4000)
        picture = tab.get_by_test_id("scene").screenshot()
        tab.get_by_test_id("joint-2").wait_for()
        assert len(picture) > 5_000  # an empty scene is a grey plane of some 3 kB
        assert tab.errors == []


def test_by_keyboard_alone(tab, project):
    with served(project) as url:
        tab.goto(url)
        tab.get_by_test_id("check").focus()
        tab.keyboard.press("Enter")
        tab.get_by_test_id("sound").wait_for(timeout=PATIENCE)
        tab.get_by_test_id("place-model").focus()
        tab.keyboard.press("Enter")
        tab.get_by_test_id("model").wait_for()


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_is_wider_than_the_screen(tab, project, width):
    tab.set_viewport_size({"width": width, "height": 800})
    with served(project) as url:
        for place in ("data", "model", "next"):
            tab.goto(f"{url}&place={place}")
            tab.get_by_test_id("verdict").wait_for()
            tab.wait_for_timeout(500)
            assert tab.evaluate("document.documentElement.scrollWidth") <= width + 1
