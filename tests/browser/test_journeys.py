"""What a person does with the workbench, done by a browser."""

import json
import re
import shlex
import shutil
import subprocess
import sys
from zipfile import ZipFile

import pytest
from fmpy.validation import validate_fmu
from steps import CURVES, PATIENCE, accessible, checked, compared, curves, pictured, served

from flexmodels.files.robot_file import load_robot
from pyident.logs.log import read_log, write_log

pytestmark = pytest.mark.browser


COUNT = "addEventListener('click', (e) => e.isTrusted && (window.clicks = (window.clicks ?? 0) + 1), true)"


def test_a_hidden_law_is_found_and_added_by_clicks(tab, project):
    """Nine clicks: check, where, compare, a bump, why, try, diagnose, add, undo."""
    tab.add_init_script(COUNT)
    with served(project) as url:
        checked(tab, url)
        tab.get_by_test_id("place-where").click()
        tab.get_by_test_id("compare").click()
        tab.get_by_test_id("where-sentence").wait_for(timeout=PATIENCE)
        assert "joint 2, motor side" in tab.get_by_test_id("where-sentence").inner_text()
        tab.get_by_test_id("job-ask").wait_for(state="detached", timeout=PATIENCE)
        tab.get_by_test_id("bump-1").click()
        tab.get_by_test_id("whole").wait_for()
        assert "from=" in tab.url
        pictured(tab, "where")
        accessible(tab)
        tab.get_by_test_id("to-why").click()
        first = tab.get_by_test_id("tie").get_by_test_id("law-1")
        first.wait_for(timeout=PATIENCE)
        assert "asymmetric_coulomb at joint2" in tab.get_by_test_id("tie").inner_text()
        assert tab.get_by_test_id("verdict").inner_text() == "no diagnosis yet"
        assert curves(tab, "waveform") == 3
        tab.get_by_test_id("try-1").click()
        tab.wait_for_function(CURVES, arg=["waveform", 4])
        before, after = re.findall(r"rms ([\d.e-]+) → ([\d.e-]+)", tab.get_by_test_id("tried").inner_text())[
            0
        ]
        assert float(after) < 0.5 * float(before)
        pictured(tab, "why")
        accessible(tab)
        tab.get_by_test_id("diagnose").click()
        tab.get_by_test_id("sentence").wait_for(timeout=PATIENCE)
        assert tab.get_by_test_id("verdict").inner_text() == "an effect is missing"
        assert "asymmetric_coulomb at joint2" in tab.get_by_test_id("finding-1").inner_text()
        tab.get_by_test_id("add-1-1").click()
        tab.get_by_test_id("version-1").wait_for(timeout=PATIENCE)
        assert tab.get_by_test_id("outcome").inner_text() == "accepted"
        fall = tab.get_by_test_id("fall-1").inner_text()
        pictured(tab, "added")
        tab.get_by_test_id("undo").click()
        tab.get_by_test_id("undo").wait_for(state="detached")
        assert tab.evaluate("window.clicks") <= 12
        assert "version=0" in tab.url
        assert tab.errors == []
        assert tab.hosts == {"127.0.0.1"}
    diagnosis = json.loads((project / "results" / "diagnose_v0.json").read_text())
    assert diagnosis["findings"][0]["tie"][0]["effect"] == "asymmetric_coulomb"
    assert (project / "with_asymmetric_coulomb_2.toml").is_file()
    assert fall == by_command_line(project, "asymmetric_coulomb", 2)


def by_command_line(project, effect: str, joint: int) -> str:
    """The first fall of the same law's waterfall, from the command that the page names."""
    lines = json.loads((project / "workbench.json").read_text())["commands"]
    line = next(c for c in lines if c.startswith(f"pyident add robot.toml {effect} --joint {joint}"))
    words = [w if not w.endswith(".json") else "again.json" for w in shlex.split(line)[1:]]
    words[words.index("-o") + 1] = "again.toml"
    subprocess.run([sys.executable, "-m", "pyident", *words], cwd=project, check=True, capture_output=True)
    step = json.loads((project / "again.json").read_text())["waterfall"][0]
    errors = f"{step['before']:.4g} → {step['after']:.4g} {step['unit']}, floor {step['floor']:.4g}"
    return f"{step['name']}, {step['data']}: {errors}"


def test_a_wrong_law_is_refused_with_its_numbers(tab, project):
    with served(project) as url:
        compared(tab, url)
        tab.get_by_test_id("place-why").click()
        rows = tab.get_by_test_id(re.compile(r"law-\d+"))
        rows.first.wait_for()
        wrong = rows.filter(has_text="viscous_drift at joint2")
        wrong.get_by_role("button", name="Add").click()
        tab.get_by_test_id("outcome").wait_for(timeout=PATIENCE)
        assert "refused: viscous_drift at joint 2" in tab.get_by_test_id("outcome").inner_text()
        assert "%" in tab.get_by_test_id("message").inner_text() or "does not fall" in (
            tab.get_by_test_id("message").inner_text()
        )
        assert tab.get_by_test_id("version-1").count() == 0
    assert not list(project.glob("with_*.toml"))


def test_a_cell_of_the_map_ranks_its_own_band(tab, project):
    with served(project) as url:
        compared(tab, url)
        tab.get_by_test_id("map").locator(".nsewdrag").first.click(position={"x": 5, "y": 5})
        band = tab.get_by_test_id("band")
        band.wait_for()
        low, high = re.findall(r"from ([\d.]+) to ([\d.]+) Hz", band.inner_text())[0]
        assert "low=" in tab.url
        assert f"--band {low} {high}" in tab.get_by_test_id("told").inner_text()
        tab.get_by_test_id("place-why").click()
        tab.get_by_test_id("stretch").wait_for()
        assert tab.get_by_test_id("stretch").inner_text().endswith(f"{low} to {high} Hz")
        assert tab.get_by_test_id("law-1").count() == 1
        pictured(tab, "why_band")
        tab.get_by_test_id("place-where").click()
        tab.get_by_test_id("band").wait_for()
        pictured(tab, "where_band")
        tab.get_by_test_id("all-frequencies").click()
        tab.get_by_test_id("band").wait_for(state="detached")
        assert "low=" not in tab.url
        assert tab.errors == []


def test_what_is_brushed_in_one_panel_is_marked_in_all(tab, project):
    with served(project) as url:
        compared(tab, url)
        panel = tab.get_by_test_id("states").locator(".nsewdrag").first
        panel.hover(position={"x": 5, "y": 5})  # waits until it stands still in sight
        box = panel.bounding_box()
        tab.mouse.down()
        tab.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + box["height"] - 5, steps=5)
        tab.mouse.up()
        tab.wait_for_function(
            "document.querySelector('[data-testid=brushed]').textContent.includes('marked')"
        )
        marked = tab.evaluate(
            """() => {
                const states = document.querySelector('[data-testid=states]').data;
                const traces = document.querySelector('[data-testid=traces]').data;
                const own = states.filter(t => t.mode === 'markers').map(t => t.selectedpoints);
                return [own, traces[traces.length - 1].x.length];
            }"""
        )
        brushed, *others = marked[0]
        assert len(others) > 2
        assert all(other == others[0] for other in others)
        assert 0 < len(others[0]) == marked[1]
        assert set(others[0]) <= set(brushed)
        assert len(brushed) - len(others[0]) <= 2  # Plotly looks once more which lie on the edge of its box
        assert tab.errors == []


def test_the_arm_plays_and_shares_its_moment_with_the_traces(tab, project):
    with served(project) as url:
        compared(tab, url)
        canvas = tab.get_by_test_id("arm")
        still = canvas.screenshot()
        tab.get_by_test_id("play").click()
        tab.wait_for_function("document.querySelector('[data-testid=scene]').dataset.time > 0.5")
        tab.get_by_test_id("play").click()
        assert canvas.screenshot() != still
        assert tab.get_by_test_id("cursor").first.is_visible()
        shown = canvas.screenshot()
        tab.get_by_test_id("exaggeration").fill("1000")
        assert tab.get_by_test_id("times").inner_text() == "500"
        assert canvas.screenshot() != shown
        assert tab.errors == []


def test_any_two_versions_are_compared(tab, project):
    """Two models whose numbers on the page are those of `pyident compare`."""
    shutil.copy(project / "robot.toml", project / "other.toml")
    versions = [
        {"model": m, "parent": "", "what": m, "command": "", "fall": None}
        for m in ("robot.toml", "other.toml")
    ]
    state = {"mapping": "", "roles": {}, "versions": versions, "current": 0, "commands": []}
    (project / "workbench.json").write_text(json.dumps(state))
    with served(project) as url:
        compared(tab, url)
        tab.get_by_test_id("compare-versions").click()
        table = tab.get_by_test_id("versions-table")
        table.wait_for(timeout=PATIENCE)
        words = table.inner_text()
    logs = [f"{name}.parquet" for name in "abc"]
    same = [sys.executable, "-m", "pyident", "compare", "robot.toml", *logs, "--json", "x.json"]
    subprocess.run(same, cwd=project, check=True, capture_output=True)
    again = json.loads((project / "x.json").read_text())["logs"]
    log = next(iter(again.values()))
    assert f"{log['torque']['joint2']['rmse']:.4g}" in words


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
        tab.get_by_test_id("arm").wait_for()
        tab.get_by_test_id("joint-2").wait_for()
        coloured = tab.evaluate(
            """() => {
                const c = document.querySelector('[data-testid=arm]');
                const bytes = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
                let blue = 0;
                for (let i = 0; i < bytes.length; i += 4)
                    blue += bytes[i] === 0x2b && bytes[i + 1] === 0x6c && bytes[i + 2] === 0xa3;
                return blue;
            }"""
        )
        assert coloured > 50  # the joints' discs
        assert tab.errors == []


def test_a_urdf_becomes_a_robot_file(tab, project):
    urdf = project / "arm.urdf"
    urdf.write_text(URDF)
    dropped = project.parent / "arm.urdf"
    urdf.rename(dropped)
    with served(project) as url:
        tab.goto(url + "&place=model")
        tab.get_by_test_id("upload-model").locator("input[type=file]").set_input_files(dropped)
        tab.get_by_test_id("twist").fill("1")
        tab.get_by_test_id("import").click()
        tab.get_by_test_id("joint-1").wait_for(timeout=PATIENCE)
        assert "shoulder · revolute, twists" in tab.get_by_test_id("joint-1").inner_text()
    assert load_robot(project / "arm.toml").joints[0].flexible
    commands = json.loads((project / "workbench.json").read_text())["commands"]
    assert commands == ["pyident robots import arm.urdf -o arm.toml --twist 1"]


URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="3"/>
<inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="50" velocity="3"/></joint></robot>"""


def test_a_bundle_holds_the_model_in_every_format(tab, project):
    with served(project) as url:
        tab.goto(url)
        tab.get_by_test_id("check").click()
        tab.get_by_test_id("sound").wait_for(timeout=PATIENCE)
        tab.get_by_test_id("place-next").click()
        tab.get_by_test_id("bundle").click()
        tab.get_by_test_id("made-bundle").wait_for(timeout=PATIENCE)
        with tab.expect_download() as saved:
            tab.get_by_test_id("download-bundle").click()
        with ZipFile(saved.value.path()) as packed:
            endings = sorted(name[name.rindex(".") :] for name in packed.namelist())
            fmu = next(n for n in packed.namelist() if n.endswith(".fmu") and "fmi3" not in n)
            packed.extract(fmu, project)
    assert endings == [".fmu", ".fmu", ".sh", ".ssp", ".toml", ".txt", ".urdf", ".xml"]
    assert validate_fmu(str(project / fmu)) == []
