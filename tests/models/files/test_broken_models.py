"""Files of other tools that are almost right end in a sentence."""

import re
from pathlib import Path

import pytest

from flexmodels.files.mjcf.importer import import_mjcf
from flexmodels.files.urdf.importer import import_urdf
from flexmodels.robot import RobotError

ARM = Path(__file__).parents[2] / "robots" / "mjcf" / "arm.xml"
URDF = """<robot name="arm"><link name="world"/><link name="a"><inertial><mass valuee="1.5"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.05"/></inertial></link>
<joint name="j" type="revolute"><parent link="world"/><child link="a"/><axis xyz="0 0 1"/>
<limit effort="1" velocity="1"/></joint></robot>"""


def test_a_mass_without_a_value(tmp_path):
    (tmp_path / "arm.urdf").write_text(URDF)
    with pytest.raises(RobotError, match="a number that URDF requires is missing"):
        import_urdf(tmp_path / "arm.urdf")


def test_a_name_that_is_no_text(tmp_path):
    pytest.importorskip("mujoco")
    named = re.sub(rb'<mujoco model="[^"]*"', b'<mujoco model="servo\x83"', ARM.read_bytes(), count=1)
    (tmp_path / "arm.xml").write_bytes(named)
    assert import_mjcf(tmp_path / "arm.xml").robot.name == "servo\N{REPLACEMENT CHARACTER}"
