"""Journeys in a real browser: a project folder with a hidden law, a server of its own, Debian's Chromium."""

import re
import shutil
from pathlib import Path

import pytest
from two_link_logs import TWO_LINK, hidden, loaded, made_log

from pyident.logs.log import write_log

pytest.importorskip("nicegui", reason="the workbench's extra is not installed")
pytest.importorskip("playwright.sync_api", reason="playwright is not installed")


@pytest.fixture(scope="session")
def recordings(tmp_path_factory) -> Path:
    """A robot file and three logs in which joint 2 takes more torque in one direction than in the other."""
    folder = tmp_path_factory.mktemp("recordings")
    shutil.copy(TWO_LINK, folder / "robot.toml")
    with loaded(hidden(), tmp_path_factory.mktemp("fmu")) as fmu:
        for number, name in enumerate(("a", "b", "c"), start=1):
            write_log(made_log(fmu, hidden(), number), folder / f"{name}.parquet")
    return folder


@pytest.fixture
def project(recordings, tmp_path) -> Path:
    folder = tmp_path / "project"
    shutil.copytree(recordings, folder)
    return folder


@pytest.fixture
def tab(browser):
    """A page that remembers which hosts it asked and what its scripts complained of."""
    page = browser.new_page(viewport={"width": 1280, "height": 1000})
    page.set_default_timeout(60_000)
    page.hosts, page.errors = set(), []
    page.on("request", lambda request: page.hosts.add(re.sub(r"^\w+://([^/:]+).*", r"\1", request.url)))
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    yield page
    page.close()
