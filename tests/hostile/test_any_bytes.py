"""Any bytes: the command ends with 0, 1 or 2 and a sentence, and leaves everything else as it was."""

import os
from contextlib import suppress
from pathlib import Path

import pytest
from hostile_files import changed_toml, changed_xml, tables
from hostile_run import Surroundings, counted, fault, run
from hypothesis import HealthCheck, Phase, given, settings

from flexmodels.files.robot_file import load_robot, shipped
from flexmodels.robot import RobotError
from pyident.simulation.references import ExperimentError
from pyident.sweep.plan import load_study_plan, planned_runs
from pyident.sweep.store import StudyError

MANY = settings(
    max_examples=int(os.environ.get("HOSTILE_EXAMPLES", "25")),
    deadline=None,
    derandomize="HOSTILE_EXAMPLES" not in os.environ,
    database=None,
    suppress_health_check=list(HealthCheck),  # pyright: ignore[reportArgumentType]
    phases=(Phase.explicit, Phase.generate),
)
ROBOTS = Path(__file__).parents[1] / "robots"
ROBOT = (ROBOTS / "two_link.toml").read_text(encoding="utf-8")
LOOP = shipped()["parallelogram"].read_text(encoding="utf-8")
URDF = """<robot name='arm'><link name='world'/>
<link name='a'><inertial><origin xyz='0 0 0.1' rpy='0 0 0'/><mass value='1.5'/>
<inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.05'/></inertial></link><link name='b'/>
<joint name='1' type='revolute'><origin xyz='0 0 1' rpy='0 0 0'/><parent link='world'/><child link='a'/>
<axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='10' velocity='2'/>
<dynamics damping='0.1' friction='0.2'/></joint>
<joint name='2' type='fixed'><parent link='a'/><child link='b'/></joint></robot>"""
MAPPING = """joints = 2
time = { source = "t", unit = "ms" }
[signals."joint{k}.e"]
source = "q{k}"
unit = "deg"
offset = [0.0, 90.0]
delay = 0.001
[signals."joint{k}.tau"]
source = "tau{k}"
sign = -1
"""
PLAN = """model = "four_link"
experiment = "identification"
design = "grid"
runs = 4
seed = 1
metrics = ["tip_error"]
[parameters]
"joint1.coulomb" = [20.0, 40.0]
"joint2.*" = 0.1
"""
NAMES = ["time", *(f"joint{k}.{s}" for k in (1, 2) for s in ("e", "eps[1]", "eps[2]", "eps[3]", "tau"))]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def tried(family, folder, files, *words):
    """Run a command on these files; it must end well."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    before = Surroundings(folder)
    done = run(*words)
    counted(family)
    assert fault(done) is None, files
    assert before.changes(("out.toml", "out.urdf", "out.csv")) == []
    if done.exit_code == 2:
        assert before.changes() == []
    for name in ("out.toml", "out.urdf", "out.csv"):
        (folder / name).unlink(missing_ok=True)
    return done


@MANY
@given(content=changed_toml(ROBOT) | changed_toml(LOOP))
def test_robot_files(content, folder):
    tried("robot files", folder, {"arm.toml": content}, "robots", "export", "arm.toml", "-o", "out.urdf")


@MANY
@given(content=changed_xml(URDF))
def test_urdfs(content, folder):
    (folder / "arm.urdf").write_bytes(content)
    before = Surroundings(folder)
    done = run("robots", "import", "arm.urdf", "-o", "out.toml")
    counted("URDFs")
    assert fault(done) is None, content
    assert before.changes(("out.toml",)) == []
    if done.exit_code == 0:
        load_robot(folder / "out.toml")  # what is imported can be used
        (folder / "out.toml").unlink()
    else:
        assert before.changes() == []


@MANY
@given(content=tables(NAMES))
def test_logs(content, folder):
    files = {"arm.toml": ROBOT.encode(), "log.csv": content}
    tried("logs", folder, files, "identify", "arm.toml", "log.csv", "-o", "out.toml")


@MANY
@given(mapping=changed_toml(MAPPING), content=tables(["t", "q1", "q2", "tau1", "tau2"]))
def test_mappings(mapping, content, folder):
    files = {"map.toml": mapping, "log.csv": content}
    tried("mappings", folder, files, "log", "import", "log.csv", "--mapping", "map.toml", "-o", "out.csv")


@MANY
@given(content=changed_toml(PLAN))
def test_plans(content, folder):
    """Plans are read and not run: a good one would take its time."""
    (folder / "plan.toml").write_bytes(content)
    counted("plans")
    for read in (planned_runs, lambda path: load_study_plan(path, most=3)):
        with suppress(StudyError, RobotError, ExperimentError, OSError):
            read(folder / "plan.toml")
