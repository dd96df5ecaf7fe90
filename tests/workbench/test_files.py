"""Places 1 and 2: files come in, are looked at, and become logs and robots, or are refused in a sentence."""

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint
from tab import Prompt, Tab, visit

from flexmodels.files.robot_file import load_robot, save_robot
from pyident.workbench import bench as benches
from pyident.workbench.bench import Bench
from pyident.workbench.places.data import keep
from pyident.workbench.project import LOGS, MODELS, ProjectError, Version, open_project
from pyident.workbench.view import View

URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="3"/>
<inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="50" velocity="3"/></joint></robot>"""


@pytest.fixture
def bench(tmp_path, monkeypatch) -> Bench:
    monkeypatch.setattr(benches, "Job", Prompt)
    return Bench(open_project(tmp_path))


class Upload:
    """A file that a browser sends."""

    def __init__(self, name: str, content: bytes = b""):
        self.name, self._content = name, content

    async def save(self, path: Path) -> None:
        path.write_bytes(self._content)


async def dropped(tab: Tab, file: Upload, endings=(*LOGS, *MODELS)) -> None:
    with tab.client:
        await keep(tab.page, cast(Any, SimpleNamespace(file=file)), endings)
    await tab.settle()


def test_files_are_kept_and_none_is_replaced(bench):
    folder = bench.project.folder

    async def steps(tab: Tab) -> None:
        assert "no-logs" in tab
        await dropped(tab, Upload("a.csv", b"first"))
        assert "no-model" in tab
        assert not tab["check"].enabled
        await dropped(tab, Upload("a.csv", b"second"))
        assert "a.csv is in the project already" in tab.notices[-1]
        await dropped(tab, Upload("a.exe"))
        assert tab.notices[-1] == "a.exe: here, files end in .csv, .parquet, .mat, .toml, .urdf, .xml"
        await dropped(tab, Upload("../a.csv"))
        assert "is not a file of this project" in tab.notices[-1]

    visit(bench, steps)
    assert (folder / "a.csv").read_bytes() == b"first"
    assert sorted(f.name for f in folder.iterdir()) == ["a.csv", "workbench.json"]


def test_a_robot_that_is_dropped_in_place_2_is_the_model(bench):
    async def steps(tab: Tab) -> None:
        assert "choose-model" in tab
        save_robot(one_joint(), bench.project.folder / ".sent")
        await dropped(tab, Upload("arm.toml", (bench.project.folder / ".sent").read_bytes()), MODELS)
        assert bench.project.model == "arm.toml"
        assert "revolute, rigid" in tab.inside("joint-1")
        assert "coulomb" in tab.inside("joint-1")
        await tab.choose("model", "four_link")
        assert bench.project.model == "four_link"
        assert "twists and bends" in tab.inside("joint-1")

    visit(bench, steps, View("model"))


def test_a_robot_file_that_cannot_be_read_says_why(bench):
    (bench.project.folder / "robot.toml").write_text("name = 3\n")
    bench.project = bench.project.starting_from("robot.toml")

    async def steps(tab: Tab) -> None:
        assert "name must be a text, not 3" in tab["model-error"].text

    visit(bench, steps, View("model"))


def test_a_urdf_is_asked_for_its_flexible_joints(bench):
    (bench.project.folder / "arm.urdf").write_text(URDF)
    bench.project = bench.project.starting_from("arm.urdf")

    async def steps(tab: Tab) -> None:
        await tab.choose("twist", "one")
        await tab.click("import")
        assert tab.notices[-1] == "joints are numbers such as 1,2, not 'one'"
        await tab.choose("twist", "1")
        await tab.click("import")
        assert "shoulder · revolute, twists" in tab.inside("joint-1")

    visit(bench, steps, View("model"))
    assert load_robot(bench.project.folder / "arm.toml").joints[0].flexible
    assert bench.project.commands == ("pyident robots import arm.urdf -o arm.toml --twist 1",)


def test_the_channels_of_a_file_are_looked_at(bench):
    """Peaks survive the thinning, in a zoom only its span is drawn, text columns are left out."""
    time = np.arange(20_000) * 1e-3
    angle = np.sin(time)
    angle[12_345] = 7.0
    frame = pd.DataFrame(
        {"time": time, "angle": angle, "note": "x", "current": np.where(time < 1, np.nan, 2.0)}
    )
    frame.to_parquet(bench.project.folder / "a.parquet")

    async def steps(tab: Tab) -> None:
        await tab.click("look-0")
        for _ in range(200):
            if "channels" in tab:
                break
            await asyncio.sleep(0.02)
        drawn = tab["channels"].figure["data"]
        assert [c["name"] for c in drawn] == ["angle", "current"]
        assert max(drawn[0]["y"]) == 7.0
        assert drawn[1]["y"][0] is None
        await tab.trigger("channels", "plotly_relayout", {"xaxis.range[0]": 2.0, "xaxis.range[1]": 3.0})
        x = tab["channels"].figure["data"][0]["x"]
        assert 1.99 <= x[0] < x[-1] <= 3.01
        await tab.trigger("channels", "plotly_relayout", {"dragmode": "zoom"})
        assert tab["channels"].figure["data"][0]["x"] == x
        await tab.trigger("channels", "plotly_relayout", {"xaxis.autorange": True})
        assert tab["channels"].figure["data"][0]["x"][-1] == pytest.approx(19.999)
        kept = tab.page.channels
        await tab.click("look-0")
        await asyncio.sleep(0.05)
        assert tab.page.channels is kept  # not read again

    visit(bench, steps)


def test_a_file_that_cannot_be_looked_at_says_why(bench):
    (bench.project.folder / "a.csv").write_text("")

    async def steps(tab: Tab) -> None:
        await tab.click("look-0")
        for _ in range(200):
            if tab.notices:
                break
            await asyncio.sleep(0.02)
        assert "a.csv" in tab.notices[-1]
        assert "channels" not in tab

    visit(bench, steps)


def test_a_proposed_mapping_is_corrected_and_used(bench):
    time = np.arange(500) * 0.01
    frame = pd.DataFrame({"t": time, "q1_deg": 40 * np.sin(time), "tau1": np.cos(time)})
    frame.to_csv(bench.project.folder / "a.csv", index=False)
    bench.project = bench.project.starting_from("")

    async def steps(tab: Tab) -> None:
        await tab.click("propose-0")
        assert "What a.csv seems to hold" in tab.words
        assert [row["column"] for row in tab["proposal"].rows] == ["t", "q1_deg", "tau1"]
        await tab.choose("mapping", tab["mapping"].value + "# seen\n")
        await tab.click("use-mapping")

    visit(bench, steps)
    assert bench.project.mapping == "mapping.toml"
    assert (bench.project.folder / "mapping.toml").read_text().endswith("# seen\n")


def test_a_log_changes_its_role(bench):
    for name in ("a.csv", "b.csv"):
        (bench.project.folder / name).write_text("")

    async def steps(tab: Tab) -> None:
        await tab.choose("role-1", "hold out")
        assert bench.project.with_role("hold out") == ["b.csv"]

    visit(bench, steps)
    assert open_project(bench.project.folder).roles == {"b.csv": "hold out"}


def test_a_version_whose_file_is_gone_is_a_sentence(bench):
    bench.project = bench.project.starting_from("robot.toml").extended(Version("../x.toml"))

    with pytest.raises(ProjectError, match="is not a file of this project"):
        _ = bench.inputs


def test_too_large_a_file_is_refused(bench):
    async def steps(tab: Tab) -> None:
        await tab.trigger("upload", "rejected", {})
        assert tab.notices[-1] == "that file is too large for a project"

    visit(bench, steps)


def test_checks_that_wait_for_a_model_begin_nothing(bench):
    bench.check()
    assert bench.jobs == {}
