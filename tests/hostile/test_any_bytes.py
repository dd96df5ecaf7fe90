"""Any bytes as a robot: exit code 0, 1 or 2, a sentence, and nothing else changes."""

from pathlib import Path

import pytest
from hostile_files import changed_toml, changed_xml
from hostile_run import MANY, cleared, tried
from hypothesis import given

from flexmodels.files.robot_file import load_robot, shipped

ROBOTS = Path(__file__).parents[1] / "robots"
ROBOT = (ROBOTS / "two_link.toml").read_text(encoding="utf-8")
LOOP = shipped()["parallelogram"].read_text(encoding="utf-8")
ARM, SERVOS = ((ROBOTS / "mjcf" / f"{name}.xml").read_text(encoding="utf-8") for name in ("arm", "servo_arm"))
URDF = """<robot name='arm'><link name='world'/>
<link name='a'><inertial><origin xyz='0 0 0.1' rpy='0 0 0'/><mass value='1.5'/>
<inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.05'/></inertial></link><link name='b'/>
<joint name='1' type='revolute'><origin xyz='0 0 1' rpy='0 0 0'/><parent link='world'/><child link='a'/>
<axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='10' velocity='2'/>
<dynamics damping='0.1' friction='0.2'/></joint>
<joint name='2' type='fixed'><parent link='a'/><child link='b'/></joint></robot>"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@MANY
@given(content=changed_toml(ROBOT) | changed_toml(LOOP))
def test_robot_files(content, folder):
    done = tried(
        "robot files", folder, {"arm.toml": content}, "robots", "export", "arm.toml", "-o", "out.urdf"
    )
    assert (folder / "out.urdf").exists() == (done.exit_code != 2)
    cleared(folder)


@MANY
@given(content=changed_toml(ROBOT) | changed_toml(LOOP))
def test_robot_files_as_mjcf(content, folder):
    done = tried(
        "robot files", folder, {"arm.toml": content}, "robots", "export", "arm.toml", "-o", "out.xml"
    )
    assert (folder / "out.xml").exists() == (done.exit_code != 2)
    cleared(folder)


@MANY
@given(content=changed_xml(URDF))
def test_urdfs(content, folder):
    imported("URDFs", folder, {"arm.urdf": content})


@MANY
@given(content=changed_xml(ARM) | changed_xml(SERVOS))
def test_mjcfs(content, folder):
    imported("MJCFs", folder, {"arm.xml": content})


def imported(family, folder, files):
    """What is imported can be used."""
    done = tried(family, folder, files, "robots", "import", *files, "-o", "out.toml")
    assert (folder / "out.toml").exists() == (done.exit_code != 2)
    if done.exit_code == 0:
        robot = load_robot(folder / "out.toml")
        assert robot.joints
    cleared(folder)
