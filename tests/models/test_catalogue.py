"""What every law of the catalogue says of itself, and where it may act."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmodels.effects import CATALOGUE
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import RobotError
from pyident.conditioning.motion import Motion
from pyident.regression.candidate_columns import coverage, effect_columns, nonlinear_grid

TWO_LINK = Path(__file__).parents[1] / "robots" / "two_link.toml"


def test_effects_stay_where_they_can_act():
    robot = load_robot(TWO_LINK)
    with pytest.raises(
        RobotError, match="joint_coupling couples a joint with the next one, and joint 2 is the last"
    ):
        robot.with_effect(2, "joint_coupling")
    with pytest.raises(RobotError, match="payload is a body at the tip; put it at the last joint, 2"):
        robot.with_effect(1, "payload")
    slider = load_robot("emps")
    with pytest.raises(RobotError, match="backlash acts on deformations that joint 1 has not"):
        slider.with_effect(1, "backlash")
    with pytest.raises(RobotError, match="gravity_spring belongs to a revolute joint"):
        slider.with_effect(1, "gravity_spring")
    assert slider.with_effect(1, "stribeck").units["joint1.stribeck.velocity"] == "m/s"
    assert slider.with_effect(1, "torque_ripple").units["joint1.torque_ripple.order"] == "rad/m"
    assert robot.with_effect(2, "torque_ripple").units["joint2.torque_ripple.order"] == "1"


def test_every_law_says_what_it_is():
    known = {p.name for effect in CATALOGUE.values() if effect.base for p in effect.parameters}
    known |= {*CATALOGUE, *load_robot(TWO_LINK).links[0].values}
    for effect in CATALOGUE.values():
        effect.check()
        assert effect.title
        assert effect.citation
        assert effect.needs
        assert effect.experiment
        assert set(effect.confounders) <= known, effect.name
        assert all(p.lower <= p.start <= p.upper for p in effect.parameters)


def test_grids_and_coverage_follow_the_motion():
    robot, rng = load_robot(TWO_LINK), np.random.default_rng(0)
    motion = Motion(*(rng.normal(size=(400, 8)) for _ in range(3)))
    velocities = [values["velocity"] for values in nonlinear_grid(robot, 1, "stribeck", [motion])]
    rms = np.sqrt(np.mean(motion.dq[:, 0] ** 2))
    np.testing.assert_allclose(velocities, rms * np.array([0.02, 0.05, 0.1, 0.2, 0.4]))
    share = np.mean(np.abs(motion.dq[:, 0]) < 0.3) / 0.05
    assert coverage(robot, 1, "stribeck", motion, {"velocity": 0.3}) == pytest.approx(share)
    with pytest.raises(
        ValueError, match=r"torque_delay at joint 1 needs the signal joint1\.tau|joint1\.time|time"
    ):
        effect_columns(robot, 1, "torque_delay", motion)


def test_a_coupling_of_a_slider_and_a_hinge_is_looked_for_at_leads_that_their_motion_shows(tmp_path):
    rigid = [line for line in TWO_LINK.read_text().splitlines() if line[:4] not in ("k = ", "d = ")]
    file = tmp_path / "rigid.toml"
    file.write_text("\n".join(rigid))
    hinges = load_robot(file)
    robot = replace(hinges, joints=(replace(hinges.joints[0], kind="prismatic"), hinges.joints[1]))
    rng = np.random.default_rng(0)
    speeds = rng.normal(size=(400, 2)) * [0.1, 3.0]  # m/s, rad/s
    motion = Motion(rng.normal(size=(400, 2)), speeds, rng.normal(size=(400, 2)))
    lead = np.sqrt(np.mean(speeds[:, 0] ** 2) / np.mean(speeds[:, 1] ** 2))
    ratios = [values["ratio"] for values in nonlinear_grid(robot, 1, "joint_coupling", [motion])]
    np.testing.assert_allclose(ratios, lead * np.array([1 / 3, 1, 3, -1 / 3, -1, -3]))
    of_hinges = nonlinear_grid(hinges, 1, "joint_coupling", [motion])
    assert [values["ratio"] for values in of_hinges] == [1.0, -1.0]


def test_a_law_is_taken_away_at_one_joint_or_at_every_joint(four_link):
    richer_at_three = four_link.with_effect(3, "stribeck").with_effect(3, "backlash")
    richer = four_link.with_effect(2, "stribeck").with_effect(3, "stribeck").with_effect(3, "backlash")
    assert richer.without_effect("stribeck") == four_link.with_effect(3, "backlash")
    assert richer.without_effect("stribeck", 2) == richer_at_three
    assert four_link.without_effect("stribeck") == four_link
