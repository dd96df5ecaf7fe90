"""From a folder of files to the law that is missing, in a tab without a browser."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from one_joint_logs import recorded
from tab import Prompt, Tab, visit

from flexmodels.files.robot_file import load_robot
from pyident.workbench import bench as benches
from pyident.workbench.bench import Bench
from pyident.workbench.project import Version, open_project
from pyident.workbench.view import View, view_of


@pytest.fixture(scope="module")
def recordings(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    recorded(folder)
    return folder


@pytest.fixture(autouse=True, scope="module")
def work_is_done_here():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(benches, "Job", Prompt)
        yield


@pytest.fixture(scope="module")
def compared(recordings):
    """A workbench whose logs are checked and compared, every law asked."""
    bench = Bench(open_project(recordings))
    for work in (bench.check, bench.compare):
        work()
        while bench.jobs:
            bench.collect()
    return bench


def test_the_checks_open_the_places(recordings):
    bench = Bench(open_project(recordings))

    async def steps(tab: Tab) -> None:
        assert "locked" in tab
        assert not tab["place-where"].enabled
        await tab.click("place-data")
        await tab.click("check")
        assert tab["told"].text == "pyident compare robot.toml a.parquet b.parquet"
        assert "1000 samples at 250 Hz" in tab.inside("log-0")
        assert "sound" in tab
        await tab.click("place-where")
        assert "no-comparison" in tab

    visit(bench, steps, View("where"))


def test_where_model_and_logs_disagree(compared):
    async def steps(tab: Tab) -> None:
        comparison = compared.result("compare").comparison
        assert tab["where-sentence"].text == comparison.sentence
        assert "joint 1, motor side" in comparison.sentence
        await tab.click("bump-1")
        bump = comparison.bumps(comparison.traces[0])[0]
        assert tab.page.view.span is not None
        low, high = tab.page.view.span
        assert low <= bump.start < bump.stop <= high
        assert tab["whole"].visible
        asked = "pyident explain robot.toml a.parquet b.parquet --log a.parquet --equation joint1.e --span"
        assert tab["told"].text == f"{asked} {low:.6g} {high:.6g}"
        await tab.trigger("traces", "plotly_relayout", {"xaxis.range[0]": 1.0, "xaxis.range[1]": 1.5})
        assert tab.page.view.span == (1.0, 1.5)
        shown = tab["traces"].figure["data"][0]["x"]
        assert 0.99 < shown[0] < shown[-1] < 1.51
        await tab.trigger("traces", "plotly_relayout", {"dragmode": "pan"})
        assert tab.page.view.span == (1.0, 1.5)
        await tab.trigger("traces", "plotly_relayout", {"xaxis.autorange": True})
        assert tab.page.view.span is None
        await tab.trigger("map", "plotly_click", {"points": [{"y": "joint1.e"}]})
        assert tab.page.view.coordinate == "joint1.e"
        assert tab["told"].text == asked.removesuffix(" --span")
        await tab.choose("log", comparison.traces[1].log)
        assert tab.page.view.log == comparison.traces[1].log
        await tab.click("to-why")
        assert "b.parquet" in tab["stretch"].text

    visit(compared, steps, View("where"))


def test_a_law_is_tried_on_a_stretch(compared):
    """What is said to remain of the residual is the rms of the curve that is drawn."""

    async def steps(tab: Tab) -> None:
        assert "asymmetric_coulomb at joint1" in tab.inside("tie")
        assert tab["explain-command"].text.endswith(
            "explain robot.toml a.parquet b.parquet --log b.parquet --equation joint1.e --span 0.5 2.5"
        )
        assert len(tab["waveform"].figure["data"]) == 3
        await tab.click("try-1")
        assert len(tab["waveform"].figure["data"]) == 4
        before, after = map(float, re.findall(r"rms ([\d.e-]+) → ([\d.e-]+)", tab["tried"].text)[0])
        assert after < 0.2 * before
        left = np.array(tab["waveform"].figure["data"][-1]["y"])
        assert np.sqrt(np.mean(left**2)) == pytest.approx(after, rel=0.1)

    log = compared.result("compare").comparison.traces[1].log
    visit(compared, steps, View("why", log, "joint1.e", (0.5, 2.5)))


def test_a_span_that_the_log_does_not_have_is_a_sentence(compared):
    async def steps(tab: Tab) -> None:
        assert "has no samples from 100 to 200 s" in tab["no-ranking"].text

    visit(compared, steps, View("why", span=(100.0, 200.0)))


def test_a_model_is_fitted_and_held_beside_the_first(compared):
    """The table's errors are those of the comparisons; undo returns to the first version."""

    async def steps(tab: Tab) -> None:
        await tab.click("identify")
        assert "version-1" in tab
        assert "13 parameters" in tab["fit"].text
        assert re.match(r"\d+ of 13 parameters are determined alone", tab["rank"].text)
        assert tab.page.bench.sound
        await tab.click("compare-versions")
        await tab.settle()
        first = tab["versions-table"].rows[0]
        before, after = (tab.page.bench.result("compare", n).comparison.logs[0] for n in (0, 1))
        name = first["signal"].split()[0]
        assert first["before"] == f"{before.equations[name].rmse:.4g}"
        assert first["after"] == f"{after.equations[name].rmse:.4g}"
        await tab.choose("version-before", 1)
        assert tab.page.pair == (1, 1)
        await tab.click("undo")
        assert tab.page.bench.project.current == 0

    bench = replace(compared, results=dict(compared.results))
    visit(bench, steps, View("model"))
    folder = bench.project.folder
    assert list(load_robot(folder / "identified.toml").joints[0].values) == [
        "motor_inertia",
        "coulomb",
        "viscous",
    ]
    line = next(c for c in bench.project.commands if c.startswith("pyident identify"))
    assert line == (
        "pyident identify robot.toml a.parquet b.parquet -o identified.toml --json results/identify_v0.json"
    )


def test_a_file_that_is_no_log_is_refused_with_its_sentence(recordings, tmp_path):
    (tmp_path / "a.csv").write_text("time,x\n0,1\n")
    (tmp_path / "robot.toml").write_bytes((recordings / "robot.toml").read_bytes())
    bench = Bench(open_project(tmp_path))

    async def steps(tab: Tab) -> None:
        await tab.click("check")
        assert "refused: " in tab.inside("log-0")
        assert not tab["place-why"].enabled

    visit(bench, steps)


def test_a_failure_of_work_is_a_sentence_on_every_page(tmp_path):
    for name in ("a.csv", "robot.toml"):
        (tmp_path / name).write_text("")
    bench = Bench(open_project(tmp_path))

    async def steps(tab: Tab) -> None:
        bench.identify()
        await tab.settle()
        assert re.search(r"identifying: .*robot\.toml: name must be a text", tab["message"].text)

    bench.results["check", bench.inputs] = {"a.csv": ["fine"]}
    (tmp_path / "robot.toml").write_text("name = 3\n")
    visit(bench, steps, View("data"))


def test_a_version_can_be_chosen_again(recordings, tmp_path):
    (tmp_path / "robot.toml").write_bytes((recordings / "robot.toml").read_bytes())
    (tmp_path / "better.toml").write_bytes((recordings / "robot.toml").read_bytes())
    project = open_project(tmp_path).extended(Version("better.toml", "robot.toml", "fitted", "pyident …"))
    bench = Bench(project)

    async def steps(tab: Tab) -> None:
        await tab.click("version-0")
        assert bench.project.model == "robot.toml"
        assert "undo" not in tab
        assert "version=0" in tab.page.view.query
        assert tab["told"].text == "pyident compare robot.toml"

    visit(bench, steps)


def test_the_link_says_which_version(recordings, tmp_path):
    """A link to a version that is there chooses it; one that is not there changes nothing."""
    (tmp_path / "robot.toml").write_bytes((recordings / "robot.toml").read_bytes())
    (tmp_path / "better.toml").write_bytes((recordings / "robot.toml").read_bytes())
    bench = Bench(open_project(tmp_path).extended(Version("better.toml", "robot.toml", "fitted", "…")))

    async def steps(_: Tab) -> None:
        assert bench.project.current == 0

    visit(bench, steps, view_of({"version": "0"}))
    for nothing in ("7", "-1", "x", "²"):
        visit(bench, steps, view_of({"version": nothing}))
