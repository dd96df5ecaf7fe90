"""Names of columns: written and read in one place."""

from dataclasses import replace

import pytest
from two_link_logs import two_link

from flexmodels.coordinate import Coordinate, divided, is_deformation, is_motor, is_torque, joint_number


@pytest.mark.parametrize("joint", [1, 2, 10, 123])
@pytest.mark.parametrize(("kind", "index"), [("e", 0), ("eps", 1), ("eps", 2), ("eps", 3)])
def test_a_name_read_back_is_the_same_coordinate(joint, kind, index):
    coordinate = Coordinate(joint, kind, index)
    assert Coordinate.parse(coordinate.name) == coordinate
    assert Coordinate.parse(coordinate.signal) == coordinate
    assert joint_number(coordinate.name) == joint


def test_what_a_coordinate_says_of_itself():
    motor, twist, bend = (Coordinate.parse(n) for n in ("joint2.e", "joint2.eps[1]", "joint2.eps[3]"))
    assert (motor.side, twist.side, bend.side) == ("motor", "transmission", "link")
    assert (motor.stiffness, twist.stiffness, bend.stiffness) == (None, "joint2.k[1]", "joint2.k[3]")
    assert (bend.rate(0), bend.rate(1), motor.rate(2)) == ("joint2.eps3", "joint2.deps3", "joint2.dde")


@pytest.mark.parametrize(
    "name", ["joint0.e", "joint1.eps[4]", "joint1.eps", "joint1.tau", "link1.e", "xjoint1.e", "joint1.e "]
)
def test_what_is_no_coordinate_is_refused_by_its_name(name):
    with pytest.raises(ValueError, match="coordinate"):
        Coordinate.parse(name)


def test_a_slider_counts_in_metres():
    two = two_link()
    slides = replace(two, joints=(replace(two.joints[0], kind="prismatic"), *two.joints[1:]))
    assert {(q.name, q.unit, q.force_unit) for q in slides.q if q.joint == 1 and q.is_motor} == {
        ("joint1.e", "m", "N")
    }
    assert slides.q[1].unit == "rad"
    assert slides.torques == ("joint1.tau", "joint2.tau")


def test_columns_that_only_look_alike_are_told_apart():
    assert is_torque("joint12.tau")
    assert not is_torque("joint1.tau_ff")
    assert not is_torque("motor1.tau")
    assert is_motor("joint3.e")
    assert not is_motor("tip.e")
    assert is_deformation("joint1.eps[2]")
    assert not is_deformation("joint1.eps2")
    assert divided("joint2.stribeck.velocity") == (2, "stribeck.velocity")
