import pytest

from flexmodels.files.robot_file import load_robot, save_robot, shipped
from flexmodels.robot import RobotError


@pytest.mark.parametrize("name", shipped())
def test_a_robot_survives_writing_and_reading(name, tmp_path):
    robot = load_robot(name)
    save_robot(robot, tmp_path / "copy.toml")
    assert load_robot(tmp_path / "copy.toml") == robot


def test_effects_and_values_survive_too(four_link, tmp_path):
    robot = four_link.with_effect(2, "asymmetric_coulomb")
    robot = robot.with_parameters({"joint2.asymmetric_coulomb.viscous": 1.5, "link3.ms[y]": 0.25}, "changed")
    save_robot(robot, tmp_path / "copy.toml")
    again = load_robot(tmp_path / "copy.toml")
    assert again == robot
    assert again.parameters["joint2.asymmetric_coulomb.viscous"] == 1.5


def test_four_link_has_the_papers_76_parameters(four_link):
    assert len(four_link.parameters) == 76
    assert len(four_link.coordinates) == 16
    assert four_link.parameters["link1.J[xx]"] == pytest.approx(1.2 + 34 * (0.02**2 + 0.24**2))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("m = 34.0", "m = -34.0", r"link\[1\]\.m = -34\.0 must be at least 0"),
        ("J_m = 6.0", "J_m = nan", r"joint\[1\]\.J_m must be a finite number"),
        ("coulomb = 30.0", "columb = 30.0", r"joint\[1\]\.columb is not a known key"),
        ("rate = 250.0", "", r"controller\.rate is missing"),
        ("x = [0.0, 0.0, 1.0]", "x = [0.0, 0.0, 2.0]", r"joint\[1\]\.x and y must be unit vectors"),
        ("tip = [0.0, 0.0, 0.535]", "tip = [0.0, 0.535]", r"tip must be 3 numbers"),
        ("k = [2.8e5, 5.5e5, 5.5e5]", "k = [2.8e5, -5.5e5, 5.5e5]", r"joint\[1\]\.k\[2\]"),
        ("J_com = [1.2, 1.1, 0.50]", "J_com = [-9.0, 1.1, 0.50]", r"link\[1\].*negative principal"),
        ("locked = [4]", "locked = [9]", r"line\.locked must be a whole number from 1 to 4, not 9"),
        ("[controller]", "[controller", "not a TOML file"),
    ],
)
def test_a_wrong_file_is_named_by_its_key(old, new, words, tmp_path):
    text = shipped()["four_link"].read_text()
    assert old in text
    (tmp_path / "wrong.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(RobotError, match=words) as caught:
        load_robot(tmp_path / "wrong.toml")
    assert "\n" not in str(caught.value)


LOOP = "[[closure]]\nlinks = [4, 5]\npoint = [-0.1, 0.0, 1.8]\naxis = [0.0, 1.0, 0.0]\n"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("parent = 1", "parent = 2", r"joint\[2\]\.parent must be a whole number from 0 to 1, not 2"),
        ("parent = 3", "parent = 1.5", r"joint\[4\]\.parent must be a whole number, not 1\.5"),
        ("tip_link = 5", "tip_link = 6", r"tip_link must be a whole number from 1 to 5"),
        (
            "joint3 = -1.0",
            "joint7 = -1.0",
            r"joint\[4\]\.follows\.joint7 is no driven joint; .* joint1 to joint3",
        ),
        ("joint3 = -1.0", "joint4 = -1.0", r"joint\[4\]\.follows\.joint4 is no driven joint"),
        ("joint3 = -1.0", "joint1 = -1.0", r"joint\[4\]\.follows\.joint1 must be a hinge that does not bend"),
        ("joint3 = -1.0", "joint3 = 1.0", r"closure\[1\]: the pin opens by 0\.\d+ m when the joints turn"),
        ("origin = [0.0, 0.0, 1.0]", "origin = [0.0, 0.0, 1.1]", r"closure\[1\]: the pin opens"),
        ("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 0.6, 0.8]", r"closure\[1\]: the pin opens"),
        ("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 1.0, 1.0]", r"closure\[1\]\.axis must be a unit vector"),
        ("links = [4, 5]", "links = [4, 9]", r"closure\[1\]\.links\[2\] must be a whole number from 1 to 5"),
        ("links = [4, 5]", "links = [4, 4]", r"closure\[1\]\.links must be two different links"),
        ("links = [4, 5]", "links = [2, 4]", r"closure\[1\]\.links\[1\] must be the rod"),
        ("passive = true", "passive = 1", r"joint\[4\]\.passive must be true or false, not 1"),
        ("passive = true", "", r"joint\[4\]\.follows is not a known key"),
        ("parent = 1", "passive = true", r"joint\[2\] is passive but stands before a driven one"),
        ("d = [900.0]", "d = [9.0, 9.0, 9.0]", r"joint\[2\]\.d must have as many numbers as joint\[2\]\.k"),
        ("k = [2.5e6]", "k = [2.5e6, 1.0]", r"joint\[2\]\.k must be 3 numbers"),
        (LOOP, "", r"closure: a loop has two passive joints and one pin, found 2 .* and 0"),
    ],
)
def test_a_wrong_linkage_is_named_by_its_key(old, new, words, tmp_path):
    text = shipped()["parallelogram"].read_text()
    assert old in text
    (tmp_path / "wrong.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(RobotError, match=words) as caught:
        load_robot(tmp_path / "wrong.toml")
    assert "\n" not in str(caught.value)


def test_a_urdf_is_no_robot_file_yet(tmp_path):
    arm = tmp_path / "arm.urdf"
    arm.write_text("<robot/>", encoding="utf-8")
    with pytest.raises(RobotError, match=r"pyident robots import arm.urdf -o arm.toml"):
        load_robot(arm)


def test_unknown_names_are_refused(four_link):
    with pytest.raises(RobotError, match="unknown robot 'nobody'"):
        load_robot("nobody")
    with pytest.raises(RobotError, match=r"there is no robot file nowhere.toml; check the path"):
        load_robot("nowhere.toml")
    with pytest.raises(RobotError, match=r"no parameter joint9\.coulomb"):
        four_link.with_parameters({"joint9.coulomb": 1.0})
    with pytest.raises(RobotError, match="unknown effect 'magic'"):
        four_link.with_effect(1, "magic")
    with pytest.raises(RobotError, match="has no joint 5"):
        four_link.with_effect(5, "offset")


SLIDER = """
[[joint]]
kind = "prismatic"
x = [1.0, 0.0, 0.0]
y = [0.0, 1.0, 0.0]
J_m = 3.0
k = {k}
[[link]]
m = 2.0
com = [0.1, 0.0, 0.0]
J_com = [0.01, 0.02, 0.02]
"""


def test_a_slider_does_not_stretch(tmp_path):
    """A belt's stiffness would be one about the slider's axis; of a carriage that tilts it is one."""
    file = tmp_path / "slider.toml"
    head = 'name = "slider"\ngravity = [0.0, 0.0, -9.81]\ntip = [0.2, 0.0, 0.0]\n'
    file.write_text(head + SLIDER.format(k="[4e5]"))
    with pytest.raises(RobotError, match="not stretch"):
        load_robot(file)
    file.write_text(head + SLIDER.format(k="[4e5, 4e5, 4e5]"))
    units = load_robot(file).units
    assert (units["joint1.J_m"], units["joint1.k[1]"]) == ("kg", "N.m/rad")
