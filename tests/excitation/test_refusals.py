"""Wishes for a motion that nobody can fulfil, each refused in one sentence before anything is simulated."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint
from planned_joint import limited

import pyident as pi
from flexmodels.experiment import Experiment
from flexmodels.joint import Limits
from flexmodels.robot import RobotError
from pyident.excitation.capsules import geometry_of
from pyident.excitation.limits import amid, limits_of, where_it_begins
from pyident.excitation.rehearsals.rehearsal import others_like, reference_of_plan, rehearsal
from pyident.excitation.rehearsals.violations import of_ends, of_reference, of_run
from pyident.excitation.separation.rivals import Suspect, having, suspect
from pyident.excitation.tables import write_table
from pyident.logs.log import Log

TIME = np.arange(501) * 0.004
TURN = 2 * np.pi  # rad/s


def swung(size: float = 1.0, time: np.ndarray = TIME) -> Experiment:
    """size (1 - cos(2 pi t)): speed 2 pi size, acceleration 4 pi² size."""
    reference = size * (1 - np.cos(TURN * time))[:, None]
    return Experiment(time, reference, np.zeros_like(reference))


@pytest.mark.parametrize(
    ("wish", "sentence"),
    [
        ({"separate": ("stribeck@1",)}, "separate takes two effects, and reveal one"),
        ({"separate": ("stribeck@1", "backlash@1"), "reveal": "backlash@1"}, "and reveal one"),
        ({"separate": ("stribeck@1", "stribeck@1")}, "stribeck@1 cannot be told from itself"),
        ({"reveal": "stribeck@1=0"}, "a size is not zero"),
        ({"reveal": "stribeck@1=much"}, "is not EFFECT@JOINT"),
        ({"seconds": 0.0}, "a search needs seconds, an evaluation and a seed from 0"),
        ({"seed": -1}, "a seed from 0"),
        ({"rate": 100.0}, "robot one_joint is driven at 250 Hz; leave the plan at that rate"),
        ({"duration": 0.0}, "the duration of a plan is 0; it must be above zero"),
        ({"duration": 0.02}, "0.02 s at 250 Hz are 5 samples; a plan has from 10"),
        ({"radius": -0.1}, "the radius of a plan is -0.1"),
        ({"floor": 1e9}, "a floor at 1e[+]09 m is none"),
        ({"noise": {"joint1.e": 0.0}}, "the noise of joint1.e of a plan is 0"),
        ({"noise": {"joint2.e": 1e-5}}, "robot one_joint has no sensor joint2.e; they are joint1.e"),
        ({"limits": {"joint2.speed": 1.0}}, "there is no limit joint2.speed; limits are joint1.lower"),
        ({"limits": {"joint1.speed": 0.0}}, "the limit joint1.speed must be above zero"),
        ({"limits": {"joint1.lower": 2.0}}, "joint1.lower must be below joint1.upper"),
        ({"floor": 9.0}, "begins in the zero pose, where link 1 is below the floor at 9 m over the base"),
        ({"limits": {"joint1.speed": 1e-3}}, "10 s is too short: the limits of speed and acceleration leave"),
        ({"home": {"joint1": 2.0}}, "joint1 cannot set out at 2, as its limits are -1.5 and 1.5"),
        ({"home": {"elbow": 0.1}}, "there is no elbow that could set out anywhere; its joints are joint1"),
    ],
)
def test_a_wish_is_refused(wish, sentence):
    with pytest.raises(RobotError, match=sentence):
        pi.excite(limited(), **wish)


def test_a_law_that_acts_already_is_no_suspect():
    log = Log(pd.DataFrame({"time": [0.0, 0.1]}))
    with pytest.raises(RobotError, match="has coulomb@1 already; give a model without it"):
        having(limited(), Suspect("coulomb", 1), log)


def test_a_suspect_of_known_size_has_it():
    log = pi.simulate(limited(), swung(0.3))
    assert (
        having(limited(), suspect("joint_spring@1=7.5"), log).parameters["joint1.joint_spring.stiffness"]
        == 7.5
    )


def test_what_a_file_leaves_open_is_not_limited_and_said():
    robot = limited()
    (joint,) = robot.joints
    free = replace(robot, joints=(replace(joint, limits=Limits()),)).with_settings(identification=None)
    ranges = {"joint1.lower": -1.0, "joint1.upper": 2.0, "joint1.speed": 3.0}
    limits = limits_of(free, ranges)
    assert (limits.acceleration[0], limits.torque[0]) == (np.inf, np.inf)
    assert limits.notes == (
        "nothing limits the acceleration of every joint",
        "nothing limits the torque of every joint",
    )
    undriven = replace(free, controller=None)
    assert limits_of(undriven, ranges | {"joint1.lower": 1.0}).home == pytest.approx([1.5])


def test_without_a_drive_the_reference_is_followed_and_torques_are_the_equation_of_motion():
    """tau = (J_m + J_zz) a + c sign(v) + d v of the one joint, about an upright axis."""
    undriven = replace(one_joint(), controller=None)
    plan = swung()
    with rehearsal(undriven) as own:
        assert own.fmu is None
        frame = own.log(plan).frame
        (other,) = own.others(plan, [undriven.with_parameters({"joint1.coulomb": 5.0})])
    v, a = TURN * np.sin(TURN * TIME), TURN**2 * np.cos(TURN * TIME)
    inside = (np.abs(v) > 1.0) & (TIME > 0.05) & (TIME < 1.95)
    expected = (0.5 + undriven.links[0].J[5]) * a + 1.0 * np.sign(v) + 2.0 * v
    tau = frame["joint1.tau"].to_numpy()
    np.testing.assert_allclose(tau[inside], expected[inside], atol=0.01 * np.ptp(expected))
    np.testing.assert_allclose((other["joint1.tau"] - tau)[inside], 4.0 * np.sign(v[inside]), atol=1e-6)


def test_a_motion_beyond_every_limit_is_told_with_its_worst_sample():
    limits = limits_of(limited(), {"joint1.acceleration": 20.0})
    geometry = geometry_of(limited(), floor=None)
    told = {v.what: v for v in of_reference(limited(), limits, geometry, reference_of_plan(swung()))}
    assert set(told) == {"position", "speed", "acceleration"}
    assert told["position"].value == pytest.approx(2.0)
    assert told["position"].time == pytest.approx(0.5)
    assert told["speed"].value == pytest.approx(TURN, rel=1e-3)
    assert told["acceleration"].value == pytest.approx(TURN**2, rel=1e-3)
    assert told["position"].sentence == (
        "joint1: the position of the reference reaches 2 rad at 0.5 s, its limit is 1.5 rad"
    )
    assert of_reference(limited(), limits_of(limited()), geometry, reference_of_plan(swung(0.2))) == []


def test_an_arm_that_dips_below_the_floor_is_told():
    """A link of 1 m that hangs from the base: its end is 1 m below, so that any floor above is met."""
    robot = limited()
    (joint,) = robot.joints
    lying = replace(robot, joints=(replace(joint, x=(0.0, 1.0, 0.0)),))
    frame = pd.DataFrame({"time": TIME, "joint1.e": np.pi / 2 * TIME / TIME[-1], "joint1.tau": 0.0 * TIME})
    geometry = geometry_of(lying, radius=0.05, floor=-0.5)
    near = [v for v in of_run(lying, limits_of(lying), geometry, frame) if v.what == "distance"]
    assert near
    assert near[0].value == pytest.approx(-0.5 - 0.05, abs=0.02)
    assert "come within -0.5" in near[0].sentence
    above = geometry_of(lying, radius=0.05, floor=-2.0)
    assert not [v for v in of_run(lying, limits_of(lying), above, frame) if v.what == "distance"]


@pytest.mark.parametrize(
    ("file", "rate", "degrees", "sentence"),
    [
        ("plan.txt", 250.0, False, "a trajectory must end in .csv, .json, .yaml"),
        ("plan.json", 250.0, True, "a ROS message is in SI units; degrees are for a table"),
        ("plan.csv", 99.0, False, "a plan of 250 points per second cannot be written at 99"),
        ("plan.csv", 0.0, False, "cannot be written at 0"),
    ],
)
def test_a_table_that_cannot_be_written_is_not_begun(tmp_path, file, rate, degrees, sentence):
    with pytest.raises(RobotError, match=sentence):
        write_table(limited(), swung(), tmp_path / file, rate, degrees)
    assert not list(tmp_path.iterdir())


def test_a_table_and_a_message_hold_the_same_motion(tmp_path):
    table = pd.read_csv(write_table(limited(), swung(), tmp_path / "plan.csv", 50.0, degrees=True))
    name = table.columns[1]
    assert len(table) == 101
    np.testing.assert_allclose(table[name], np.degrees(1 - np.cos(TURN * table["time"])), atol=1e-9)
    points = json.loads(write_table(limited(), swung(), tmp_path / "plan.json", 50.0).read_text())["points"]
    positions = [point["positions"][0] for point in points]
    np.testing.assert_allclose(np.degrees(positions), table[name], atol=1e-9)
    text = write_table(limited(), swung(), tmp_path / "plan.yaml", 50.0).read_text()
    assert json.loads(text.splitlines()[3].removeprefix("- ")) == points[0]


def test_two_samples_are_no_motion():
    with pytest.raises(RobotError, match="a plan of 2 samples is no motion; give 3 at least"):
        reference_of_plan(swung(time=TIME[:2]))


def test_other_robots_are_off_by_what_is_said():
    """Every law's value by 10 to 25 %; a link without mass keeps its form."""
    robot = one_joint()
    massless = replace(robot, links=(replace(robot.links[0], m=0.0, ms=(0.0, 0.0, 0.0)),))
    for other in others_like(massless, 5):
        off = abs(other.parameters["joint1.viscous"] / 2.0 - 1)
        assert 0.10 <= off <= 0.25
        ratio = np.array(other.links[0].J)[[0, 3, 5]] / np.array(massless.links[0].J)[[0, 3, 5]]
        assert np.ptp(ratio) == pytest.approx(0.0, abs=1e-12)
        assert other.links[0].m == 0.0


def test_where_a_motion_begins_is_named_by_the_joints_that_cannot_stand_at_zero():
    free = replace(limited(), controller=None)
    assert where_it_begins(free, limits_of(free)) == "in the zero pose"
    outside = limits_of(free, {"joint1.lower": 0.5})
    assert where_it_begins(free, outside) == "with joint1 at 1 rad"
    assert amid(free, outside, {}) == (
        "a motion sets out with joint1 at 1 rad, amid its range, as 0 is outside; --home gives another place",
    )
    assert amid(free, limits_of(free, {"joint1.lower": 0.5}, {"joint1": 0.6}), {"joint1": 0.6}) == ()


def test_a_motion_that_does_not_begin_at_rest_is_told_with_its_speed():
    """A ramp of 0.5 rad/s jumps at both ends; an even acceleration of 2 rad/s2 only where it ends."""
    limits = limits_of(limited())

    def told(q: np.ndarray) -> list[str]:
        plan = Experiment(TIME, q[:, None], np.zeros((len(TIME), 1)))
        return [v.sentence for v in of_ends(limited(), limits, reference_of_plan(plan))]

    assert told(0.5 * TIME) == [
        "joint1: the reference starts at 0.5 rad/s and not at rest, so its speed jumps",
        "joint1: the reference ends at 0.5 rad/s and not at rest, so its speed jumps",
    ]
    assert told(TIME**2) == ["joint1: the reference ends at 4 rad/s and not at rest, so its speed jumps"]
    assert told(swung().reference[:, 0]) == []


@pytest.mark.parametrize("rate", [250.0, 31.25])
def test_a_trajectory_ends_where_the_plan_ends_and_stands_there(tmp_path, rate):
    """Of 31.25 points a second the last would be 8 ms early; at rest is exactly zero, a ramp is not."""
    path = write_table(limited(), swung(), tmp_path / "plan.json", rate)
    points = json.loads(path.read_text())["points"]
    first, last = points[0], points[-1]
    assert last["time_from_start"] == {"sec": 2, "nanosec": 0}
    for point in (first, last):
        assert point["velocities"] == point["accelerations"] == [0.0]
    assert max(abs(point["velocities"][0]) for point in points) > 3.0
    ramp = Experiment(TIME, TIME[:, None], np.zeros((len(TIME), 1)))
    path = write_table(limited(), ramp, tmp_path / "ramp.json", rate)
    assert json.loads(path.read_text())["points"][0]["velocities"] == pytest.approx([1.0])
