"""FMI's names of parameters are unique and indexed as arrays are."""

from flexfmu.names import fmi_name
from flexmodels.files.robot_file import load_robot, shipped


def test_arrays_are_indexed_by_numbers():
    assert fmi_name("link1.ms[x]") == "link1.ms[1]"
    assert fmi_name("link12.J[yz]") == "link12.J[2,3]"
    assert fmi_name("joint2.k[3]") == "joint2.k[3]"
    assert fmi_name("joint1.stribeck.velocity") == "joint1.stribeck.velocity"


def test_no_two_parameters_share_a_name():
    for robot in shipped():
        names = list(load_robot(robot).parameters)
        assert len({fmi_name(name) for name in names}) == len(names)
