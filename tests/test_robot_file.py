import pytest

from flexmodels.robot import RobotError
from flexmodels.robot_file import load_robot, save_robot, shipped


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
        ("locked = [4]", "locked = [9]", r"line\.locked must name joints from 1 to 4"),
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


def test_unknown_names_are_refused(four_link):
    with pytest.raises(RobotError, match="unknown robot 'nobody'"):
        load_robot("nobody")
    with pytest.raises(RobotError, match=r"no parameter joint9\.coulomb"):
        four_link.with_parameters({"joint9.coulomb": 1.0})
    with pytest.raises(RobotError, match="unknown effect 'magic'"):
        four_link.with_effect(1, "magic")
    with pytest.raises(RobotError, match="has no joint 5"):
        four_link.with_effect(5, "offset")
