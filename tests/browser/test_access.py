"""The workbench by keyboard, on a phone, and for those who do not see its colours."""

import pytest
from steps import CURVES, PATIENCE, accessible, served

pytestmark = pytest.mark.browser


def test_by_keyboard_alone(tab, project):
    """Tab reaches every control in turn and Enter works it; the focus can be seen."""
    with served(project) as url:
        tab.goto(url)
        tab.get_by_test_id("check").wait_for()
        tabbed(tab, "check")
        tab.keyboard.press("Enter")
        tab.get_by_test_id("sound").wait_for(timeout=PATIENCE)
        tabbed(tab, "place-where")
        tab.keyboard.press("Enter")
        tabbed(tab, "compare")
        tab.keyboard.press("Enter")
        tab.get_by_test_id("where-sentence").wait_for(timeout=PATIENCE)
        tab.get_by_test_id("job-ask").wait_for(state="detached", timeout=PATIENCE)
        tabbed(tab, "bump-1")
        tab.keyboard.press("Enter")
        tab.get_by_test_id("whole").wait_for()
        tabbed(tab, "to-why")
        tab.keyboard.press("Enter")
        tabbed(tab, "try-1")
        tab.keyboard.press("Space")
        tab.wait_for_function(CURVES, arg=["waveform", 4])
        assert tab.errors == []


def tabbed(tab, name: str, most: int = 120) -> None:
    """Press Tab until a control has the focus."""
    for _ in range(most):
        if tab.evaluate("document.activeElement?.dataset?.testid ?? ''") == name:
            return
        tab.keyboard.press("Tab")
    raise AssertionError(f"{most} times Tab do not reach {name}")


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_is_wider_than_the_screen(tab, project, width):
    tab.set_viewport_size({"width": width, "height": 800})
    with served(project) as url:
        for place in ("data", "model", "next"):
            tab.goto(f"{url}&place={place}")
            tab.get_by_test_id("verdict").wait_for()
            tab.wait_for_timeout(500)
            assert tab.evaluate("document.documentElement.scrollWidth") <= width + 1


@pytest.mark.parametrize("place", ["data", "model", "next"])
def test_everybody_can_use_it(tab, project, place):
    with served(project) as url:
        tab.goto(f"{url}&place={place}")
        tab.get_by_test_id("verdict").wait_for()
        tab.wait_for_timeout(500)
        accessible(tab)
