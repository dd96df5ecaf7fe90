import os
import shutil
from pathlib import Path

import pytest
from hypothesis import settings

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import identification
from flexmodels.files.robot_file import load_robot
from flexmodels.mechanics.plant import equations
from pyident.logs.log import Log

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
_FLAGS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]

settings.register_profile("the same cases every time", derandomize=True)
settings.load_profile("the same cases every time")


@pytest.fixture(scope="session")
def four_link():
    return load_robot("four_link")


@pytest.fixture(scope="session")
def four_link_fmu(four_link, tmp_path_factory):
    return export_fmu(equations(four_link), tmp_path_factory.mktemp("fmu") / "four_link.fmu")


@pytest.fixture(scope="session")
def fmus(four_link, four_link_fmu, tmp_path_factory):
    """The FMU by version of the standard, with derivatives."""
    newer = tmp_path_factory.mktemp("fmu3") / "four_link.fmu"
    return {2: four_link_fmu, 3: export_fmu(equations(four_link), newer, fmi=3)}


@pytest.fixture(scope="session")
def identification_log(four_link, four_link_fmu):
    """Noise-free log of the paper's identification experiment."""
    with LoadedFmu(four_link_fmu) as fmu:
        return Log(fmu.simulate(identification(four_link)), "identification")


@pytest.fixture(scope="session")
def data():
    """Folder of measured data sets."""
    folder = Path(os.environ.get("PYIDENT_DATA", "data"))
    if not folder.is_dir():
        pytest.skip("measured data are not here: set PYIDENT_DATA to their folder")
    return folder


@pytest.fixture(scope="session")
def browser():
    """One for all tests: a second one beside it would need an event loop of its own."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("no Chromium: apt install chromium, or name one in CHROMIUM")
    with playwright.sync_playwright() as tools:
        browser = tools.chromium.launch(executable_path=CHROMIUM, args=_FLAGS)
        yield browser
        browser.close()
