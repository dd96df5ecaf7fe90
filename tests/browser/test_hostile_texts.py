"""Names from files stay text on every page."""

import shutil
import tomllib

import pytest
import tomli_w
from steps import PATIENCE, checked, served

NASTY = "<img src=x onerror=document.title=`ran`><script>document.title=`ran`</script>{{7*7}}"

pytestmark = pytest.mark.browser


def test_names_from_files_run_nothing(tab, project):
    robot = project / "robot.toml"
    content = tomllib.loads(robot.read_text(encoding="utf-8")) | {"name": NASTY, "description": NASTY}
    robot.write_text(tomli_w.dumps(content), encoding="utf-8")
    for name in "abc":
        log = project / f"{name}.parquet"
        shutil.move(log, log.with_name(f"{name}<img src=x onerror=document.title=`ran`>.parquet"))
    with served(project) as url:
        checked(tab, url)
        title = tab.title()
        for place in ("model", "where", "why", "next"):
            tab.get_by_test_id(f"place-{place}").click()
            tab.wait_for_timeout(2000)
            assert tab.locator("img[src=x]").count() == 0
            assert tab.title() != "ran"
        tab.get_by_test_id("place-where").click()
        tab.get_by_test_id("compare").click()
        tab.get_by_test_id("where-sentence").wait_for(timeout=PATIENCE)
        assert tab.locator("img[src=x]").count() == 0
        assert (tab.title(), tab.errors) == (title, [])
        assert tab.hosts == {"127.0.0.1"}
