"""Robots from other people's files, and the bundle of all formats."""

from zipfile import ZipFile

import numpy as np
import pytest
from two_link_logs import TWO_LINK

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import RobotError
from pyident.verbs.robots import bundle, import_robot

URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="3"/>
<inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="50" velocity="3"/></joint></robot>"""


def test_a_urdf_becomes_a_robot_file(tmp_path):
    (tmp_path / "arm.urdf").write_text(URDF)
    import_robot(tmp_path / "arm.urdf", tmp_path / "arm.toml", twist=[1])
    joint = load_robot(tmp_path / "arm.toml").joints[0]
    assert joint.flexible
    assert not joint.bends
    np.testing.assert_allclose(joint.x, (0, 1, 0))


def test_a_file_that_is_no_robot_is_refused_and_nothing_is_written(tmp_path):
    (tmp_path / "arm.urdf").write_text("<html/>")
    with pytest.raises(RobotError):
        import_robot(tmp_path / "arm.urdf", tmp_path / "arm.toml")
    assert not (tmp_path / "arm.toml").exists()


def test_a_bundle_holds_every_format_and_the_same_robot(tmp_path):
    file = bundle(TWO_LINK, tmp_path / "all.zip", "#!/bin/sh\npyident robots\n")
    with ZipFile(file) as packed:
        names = packed.namelist()
        packed.extractall(tmp_path / "out")
    robot = load_robot(TWO_LINK)
    assert {n.rpartition(".")[2] for n in names} == {"fmu", "sh", "ssp", "toml", "txt", "urdf", "xml"}
    assert load_robot(tmp_path / "out" / f"{robot.name}.toml").parameters == robot.parameters
    assert "urdf" in (tmp_path / "out" / "NOTES.txt").read_text()  # it holds no elasticity
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]
