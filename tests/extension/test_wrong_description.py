"""A robot file that is wrong is named, and measured on demand; torques are Pinocchio's."""

from dataclasses import replace

import pytest
from six_axis_logs import arm, made, plain

from flexmodels.robot import Robot
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched
from pyident.extension.add_effect import add_effect
from pyident.regression.descriptions import corrected
from pyident.simulation.fmu_runs import FmuRuns

LONGER = 0.006  # m, of the upper arm
TILT = 0.0035  # rad, of the base
PACE = 6.0  # a slow arm feels gravity alone, and that a link's mass explains as well


def longer(robot: Robot) -> Robot:
    x, y, z = robot.joints[2].origin
    joint = replace(robot.joints[2], origin=(x + LONGER, y, z))
    return replace(robot, joints=(*robot.joints[:2], joint, *robot.joints[3:]))


def logs_of(robot: Robot, pace: float, friction=plain):
    return [made(robot, seed, friction, 20.0, pace) for seed in range(3)]


@pytest.fixture(scope="module")
def logs():
    return logs_of(longer(arm()), PACE)


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def found_in(logs):
    """The last log is held out."""
    return concluded(searched(arm(), logs[:2], never), never, logs[2:])


def test_a_longer_link_is_named_and_no_law_in_its_place(logs):
    """All joints stand below their floors; held-out logs show the length far beyond chance."""
    found = found_in(logs)
    assert found.verdict == "missing_effect"
    ((named,),) = (f.tie for f in found.findings)
    assert (named.effect, named.joint) == ("origin[x]", "joint3")
    assert named.values["correction"] == pytest.approx(LONGER, rel=0.1)
    value = f"{named.values['correction']:.2g} m"
    assert found.sentence.startswith(f"Wrong: joint3.origin[x] of the robot file by about {value} (")
    assert named.std["correction"] == float("inf")  # it would be too small


@pytest.mark.slow
def test_a_tilted_base_ties_with_all_that_loads_its_first_joint_alike():
    """With the axis that stands on it, and with a spring that pulls as gravity does."""
    found = found_in(logs_of(corrected(arm(), 1, "base_tilt[y]", TILT), 3.0))
    assert found.verdict == "cannot_tell"
    (finding,) = found.findings
    tie = {(n.effect, n.joint): n for n in finding.tie}
    assert {("base_tilt[y]", "joint1"), ("axis[z]", "joint1"), ("gravity_spring", "joint1")} <= tie.keys()
    assert tie["base_tilt[y]", "joint1"].values["correction"] == pytest.approx(TILT, rel=0.1)
    assert found.sentence.startswith("Missing or wrong: ")


@pytest.mark.slow
def test_a_base_tilted_about_two_axes_is_no_spring_at_its_first_joint():
    tilted = arm()
    for name, angle in (("base_tilt[x]", 0.02), ("base_tilt[y]", 0.01)):
        tilted = corrected(tilted, 1, name, angle)
    found = found_in(logs_of(tilted, 4.0))
    assert all(n.describes for f in found.findings for n in f.tie)
    firsts = {f.tie[0].effect: f.tie[0].values["correction"] for f in found.findings}
    assert firsts == {
        "base_tilt[x]": pytest.approx(0.02, rel=0.1),
        "base_tilt[y]": pytest.approx(0.01, rel=0.1),
    }
    assert ", these logs cannot tell which; base_tilt[" in found.sentence


@pytest.mark.parametrize("pace", [pytest.param(1.0, marks=pytest.mark.slow), 6.0])
def test_a_right_robot_file_is_not_called_wrong(pace):
    found = found_in(logs_of(arm(), pace))
    assert found.verdict == "nothing_detectable"
    assert not any("robot file may be wrong" in note for note in found.notes)


@pytest.mark.slow
def test_a_longer_link_is_measured_and_passes_the_gate(logs):
    done = add_effect(arm(), 3, "origin[x]", logs[:2], logs[2:], FmuRuns, lambda _: None)
    assert not done.asked.admission.reason
    assert done.accepted, done.reason  # though its torques are those of a stand-in for the loop
    assert done.correction is not None
    assert done.correction.amount == pytest.approx(LONGER, rel=0.05)
    assert done.robot.joints[2].origin == pytest.approx(longer(arm()).joints[2].origin, abs=0.05 * LONGER)
