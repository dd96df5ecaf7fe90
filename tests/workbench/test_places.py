"""What each place says of results that are there, without the work that leads to them."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from one_joint import one_joint
from tab import Endless, Tab, visit

from flexmodels.files.formats import imported
from flexmodels.files.robot_file import save_robot
from flexmodels.gearing import Transmission
from pyident.diagnosis.result import Diagnosis, Finding, Limit, Named
from pyident.extension.waterfall import Step
from pyident.workbench import bench as benches
from pyident.workbench import work
from pyident.workbench.bench import Bench
from pyident.workbench.places.why import _Stretch
from pyident.workbench.project import open_project
from pyident.workbench.view import View

UserDownload = pytest.importorskip("nicegui.testing.user_download").UserDownload
LAWS = tuple(
    Named(effect, "joint1", {"coulomb": 1.5}, {"coulomb": 0.1}, {"coulomb": "N.m"}, gain, nonlinear=())
    for effect, gain in (("asymmetric_coulomb", 90.0), ("joint_spring", 80.0))
)
DIAGNOSIS = Diagnosis(
    robot="one_joint",
    logs=("a.parquet",),
    heldout=(),
    verdict="cannot_tell",
    sentence="asymmetric_coulomb or joint_spring: these logs cannot tell which.",
    findings=(
        Finding(LAWS, 1 / 21, 88.0, 97.2, 41.4, "slow swings"),
        Finding(LAWS[:1], 1 / 21, 88.0, 50.0, None),
    ),
    localised=("joint1", "motor"),
    limits=(
        Limit("backlash", "joint1", {}, {}, 0.3),
        Limit("payload", "joint1", {}, {}, 120.0, "the logs do not cover it"),
    ),
    rows=(),
    excess=7.25,
    remaining=1.17,
    ranking=LAWS,
    notes=(),
    noise={},
    stages=(),
)
STEPS = (Step("torque", "N.m", 2.0, 1.0, 0.5), Step("torque", "N.m", 1.5, 0.5, 0.5, "fitted"))
ACCEPTED = work.Outcome("", STEPS, (0.5, 0.4))


@pytest.fixture
def bench(tmp_path, monkeypatch) -> Bench:
    """A project whose log has passed its checks; what is begun never ends."""
    monkeypatch.setattr(benches, "Job", Endless)
    (tmp_path / "a.parquet").write_bytes(b"")
    save_robot(one_joint(), tmp_path / "robot.toml")
    bench = Bench(open_project(tmp_path))
    bench.results["check", bench.inputs] = {"a.parquet": ["1000 samples"]}
    return bench


def begun(bench: Bench, what: str) -> Endless:
    return cast(Endless, bench.jobs[what])


def test_work_under_way_is_shown_and_can_be_cancelled(bench):
    async def steps(tab: Tab) -> None:
        await tab.click("diagnose")
        assert tab["job-diagnose"].text == "diagnosing …"
        assert not tab["diagnose"].enabled
        job = begun(bench, "diagnose")
        await tab.click("cancel-diagnose")
        assert job.cancelled
        assert "job-diagnose" not in tab

    visit(bench, steps, View("why"))
    assert bench.project.commands == (
        "pyident diagnose robot.toml a.parquet --json results/diagnose_v0.json",
    )


def test_asking_again_ends_what_was_asked_before(bench):
    bench.diagnose()
    first = begun(bench, "diagnose")
    bench.diagnose()
    assert first.cancelled
    bench.close()
    assert bench.jobs == {}


def test_a_verdict_is_said_with_its_tie_and_its_numbers(bench):
    bench.results["diagnose", bench.inputs] = DIAGNOSIS

    async def steps(tab: Tab) -> None:
        assert tab["verdict"].text == "these logs cannot tell"
        assert tab["sentence"].text == DIAGNOSIS.sentence
        tie, single = tab.inside("finding-1"), tab.inside("finding-2")
        assert "These logs cannot tell these apart:" in tie
        assert "asymmetric_coulomb at joint1\ncoulomb = 1.5 N.m" in tie
        assert "takes 97 % of what exceeds the floor there, 41 % on held-out data" in tie
        assert "To separate: slow swings" in tie
        assert single.endswith("takes 50 % of what exceeds the floor there")
        assert "no-ranking" in tab
        await tab.click("add-1-2")
        job = begun(bench, "add")
        assert job.arguments[1:3] == ("joint_spring", 1)
        assert not tab["add-1-2"].enabled

    visit(bench, steps, View("why"))


@pytest.mark.parametrize("reason", ["", "the error rises by 3 %"])
def test_the_outcome_of_a_law_is_said_with_its_fall(bench, reason):
    bench.results["add", bench.inputs] = replace(ACCEPTED, reason=reason)

    async def steps(tab: Tab) -> None:
        assert tab["outcome"].text == (f"refused: {reason}" if reason else "accepted")
        assert tab["fall-1"].text == "torque, held out: 2 → 1 N.m, floor 0.5"
        assert tab["fall-2"].text == "torque, fitted: 1.5 → 0.5 N.m, floor 0.5"
        over_floor = {bar["name"]: bar["y"] for bar in tab["waterfall"].figure["data"]}
        assert over_floor == {
            "before, held out": [4.0],
            "after, held out": [2.0],
            "before, fitted": [3.0],
            "after, fitted": [1.0],
        }

    visit(bench, steps, View("why"))


def test_an_accepted_law_becomes_the_model_that_is_compared(bench):
    bench.add("asymmetric_coulomb", 1)
    job = cast(Any, SimpleNamespace(running=False, state="done", result=ACCEPTED, title="adding"))
    save_robot(one_joint(), bench.project.folder / "with_asymmetric_coulomb_1.toml")
    bench.jobs["add"] = job
    bench.collect()
    assert bench.project.model == "with_asymmetric_coulomb_1.toml"
    assert bench.project.versions[1].fall == (0.5, 0.4)
    assert begun(bench, "compare").work is work.compared
    assert Path(begun(bench, "compare").arguments[0].model).name == "with_asymmetric_coulomb_1.toml"


def test_what_to_measure_next_follows_from_the_diagnosis(bench):
    bench.results["diagnose", bench.inputs] = DIAGNOSIS

    async def steps(tab: Tab) -> None:
        assert "asymmetric_coulomb at joint1 or joint_spring at joint1? slow swings" in tab.words
        assert "payload at joint1 cannot be seen: the logs do not cover it" in tab.words
        assert "backlash" not in tab.words  # these logs would have shown it
        await tab.click("plan-1")
        job = begun(bench, "plan")
        assert job.arguments[1:3] == (("asymmetric_coulomb@1=coulomb=1.5", "joint_spring@1=coulomb=1.5"), "")
        bench.cancel("plan")
        await tab.settle()
        await tab.click("plan-2")
        assert begun(bench, "plan").arguments[1:3] == ((), "payload@1")

    visit(bench, steps, View("next"))
    both = "asymmetric_coulomb@1=coulomb=1.5 joint_spring@1=coulomb=1.5"
    assert [c.partition(" --json")[0] for c in bench.project.commands] == [
        f"pyident excite robot.toml --separate {both} -o plan.csv",
        "pyident excite robot.toml --reveal payload@1 -o plan.csv",
    ]
    assert bench.project.roles == {"plan.csv": "leave out"}


def test_a_plan_says_what_it_promises_and_is_downloaded(bench, monkeypatch):
    sent: list[Any] = []
    monkeypatch.setattr(UserDownload, "__call__", lambda _, source, *rest: sent.append(source))
    (bench.project.folder / "plan.csv").write_text("time\n")
    bench.change(bench.project.having_role("plan.csv", "leave out").after("pyident excite …"))
    bench.results["plan", bench.inputs] = "plan.csv", "separates both by 9 standard deviations"

    async def steps(tab: Tab) -> None:
        assert tab["no-experiment"].text == "Run the diagnosis in place 4 first."
        assert tab["promise"].text == "plan.csv: separates both by 9 standard deviations"
        for what in ("plan", "model", "script"):
            await tab.click(f"download-{what}")

    visit(bench, steps, View("next"))
    files = [bench.project.folder / name for name in ("plan.csv", "robot.toml")]
    assert sent == [*files, "#!/bin/sh\nset -e\npyident excite …\n"]


def test_a_model_leaves_in_the_formats_that_are_asked_for(bench):
    async def steps(tab: Tab) -> None:
        await tab.click("export-fmi3")
        assert begun(bench, "export").arguments[1:] == (str(bench.project.folder / "robot.fmu"), 3)
        await tab.click("bundle")
        assert begun(bench, "bundle").arguments[1].endswith("robot_bundle.zip")
        bench.close()
        bench.results["export", bench.inputs] = str(bench.project.folder / "robot.fmu")
        bench.revision += 1
        await tab.settle()
        assert tab["made-export"].text == "wrote robot.fmu"
        assert "pyident export robot.toml -o robot.fmu --fmi 3" in tab["script"].text

    visit(bench, steps, View("next"))


def test_nothing_to_ask_is_said(bench):
    bench.results["diagnose", bench.inputs] = replace(DIAGNOSIS, findings=(), limits=())

    async def steps(tab: Tab) -> None:
        assert tab["no-experiment"].text == "The diagnosis asks for no further motion."

    visit(bench, steps, View("next"))


def test_single_formats_and_reports_are_commands_too(bench):
    bench.results["diagnose", bench.inputs] = DIAGNOSIS

    async def steps(tab: Tab) -> None:
        for name in ("urdf", "mjcf", "ssp"):
            await tab.click(f"export-{name}")
            bench.cancel("export")
            await tab.settle()
        assert not tab["report-compare"].enabled  # nothing has been compared
        await tab.click("report-diagnose")
        job = begun(bench, "report")
        job.work(*job.arguments, progress=lambda _: None)

    visit(bench, steps, View("next"))
    assert list(bench.project.commands) == [
        "pyident robots export robot.toml -o robot.urdf",
        "pyident robots export robot.toml -o robot.xml",
        "pyident export robot.toml -o robot.ssp",
        "pyident diagnose robot.toml a.parquet -o robot_diagnose.html",
    ]
    page = (bench.project.folder / "robot_diagnose.html").read_text()
    assert "these logs cannot tell which" in page


@pytest.mark.parametrize("ending", [".urdf", ".xml"])
def test_what_is_exported_reads_back(bench, ending):
    bench.export(ending)
    job = begun(bench, "export")
    name = job.work(*job.arguments, progress=lambda _: None)
    assert len(imported(name)[0].joints) == len(one_joint().joints)


def test_what_only_imitates_is_greyed_with_its_reason_in_sight(bench):
    """The sentence stands on the page itself; a law that the diagnosis does not speak of has none."""
    reason = "joint_spring at joint1 fits in part (12 %), but only together with the finding."
    stretch = _Stretch.__new__(_Stretch)
    stretch.diagnosis = SimpleNamespace(depends_on=(reason,))
    assert stretch._imitates(SimpleNamespace(name="joint_spring at joint1")) == reason
    assert stretch._imitates(SimpleNamespace(name="backlash at joint1")) == ""


def test_the_joints_drive_and_transmission_are_named(bench):
    geared = replace(one_joint(), transmission=Transmission(((50.0,),), (0.0,), (0.25,)))
    save_robot(geared, bench.project.folder / "robot.toml")

    async def steps(tab: Tab) -> None:
        assert "transmission 50, 0.25 N m/A" in tab.words
        assert "PID at 250 Hz, torque held" in tab.words

    visit(bench, steps, View("model"))
