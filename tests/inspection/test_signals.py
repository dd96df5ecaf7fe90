"""Units and kinds of columns by how they move, each against a motion whose derivative is known."""

import re
import tomllib
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from analytic_joint import analytic_log, free_joint
from one_joint import one_joint

from flexmodels.files.robot_file import load_robot
from flexmodels.settings.servo import Servo
from pyident.inspection.channel import Channel
from pyident.inspection.inspect_log import inspect_log
from pyident.inspection.motion import with_motion_units, with_velocities_found
from pyident.inspection.nameless import nameless
from pyident.inspection.proposal import Proposal
from pyident.logs.foreign import import_log
from pyident.logs.log import LogError

RATE = 100.0
TIME = np.arange(1000) / RATE
ANGLE = np.sin(0.7 * TIME)  # rad
SPEED = 0.7 * np.cos(0.7 * TIME)


def column(
    name: str, values: np.ndarray, signal: str, unit: str | None = None, joint: int | None = 1
) -> Channel:
    return Channel(name, values, RATE, signal, joint, "joint", unit)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(("unit", "factor"), [("rad", 1.0), ("deg", 180 / np.pi), ("rev", 0.5 / np.pi)])
def test_the_unit_of_a_position_follows_from_its_velocity(unit, factor):
    """A range of 0.5 deg to 57 would say nothing: the derivative does."""
    channels = [column("a", factor * ANGLE, "position"), column("b", SPEED, "velocity", "rad/s")]
    found = with_motion_units(channels, None, 1 / RATE)[0]
    assert (found.unit, found.sure) == (unit, True)
    assert "the derivative that its velocity is" in found.why


def test_a_position_against_its_velocity_is_asked():
    channels = [column("a", -ANGLE, "position"), column("b", SPEED, "velocity", "rad/s")]
    found = with_motion_units(channels, None, 1 / RATE)[0]
    assert not found.sure
    assert found.doubt == "a has the sign opposite to b: which of them is right?"


def test_a_velocity_that_belongs_to_something_else_says_nothing():
    other = np.cos(5 * TIME)
    channels = [column("a", ANGLE, "position"), column("b", other, "velocity", "rad/s")]
    found = with_motion_units(channels, None, 1 / RATE)[0]
    assert found.why == ("its range up to 1",)


@pytest.mark.parametrize(
    ("values", "unit", "question"),
    [
        (np.round(4000 * ANGLE), None, "how many counts make a turn"),
        (10.0 * ANGLE, "deg", "is a in radians or degrees? it reaches 10"),
        (3.0 * ANGLE, "rad", ""),
        (90.0 * ANGLE, "deg", "is a in degrees, in radians or turns of several turns, or in parts"),
        (170.0 * ANGLE, "deg", ""),
    ],
)
def test_a_range_tells_a_unit_or_is_asked(values, unit, question):
    found = with_motion_units([column("a", values, "position")], None, 1 / RATE)[0]
    assert found.unit == unit
    assert question in found.doubt
    assert found.sure == (not question)


@pytest.mark.parametrize(
    ("reach", "unit", "sure"), [(0.4, "m", True), (400.0, "mm", True), (8.0, "mm", False)]
)
def test_a_slider_is_in_metres_or_millimetres(reach, unit, sure):
    robot = one_joint()
    slider = replace(robot, joints=(replace(robot.joints[0], kind="prismatic"),))
    found = with_motion_units([column("a", reach * ANGLE, "position")], slider, 1 / RATE)[0]
    assert (found.unit, found.sure) == (unit, sure)


def test_one_sure_position_tells_the_unit_of_the_others():
    doubtful = column("b", 10.0 * ANGLE, "position", joint=2)
    found = with_motion_units([column("a", 170.0 * ANGLE, "position"), doubtful], None, 1 / RATE)
    assert (found[1].unit, found[1].sure) == ("deg", True)
    assert found[1].why[-1] == "the unit of the other positions"


@pytest.mark.parametrize(
    ("unit", "factor"), [("rad/s", 1.0), ("deg/s", 180 / np.pi), ("rpm", 30 / np.pi), ("rev/s", -0.5 / np.pi)]
)
def test_the_unit_and_sign_of_a_velocity_follow_from_its_position(unit, factor):
    channels = [column("a", ANGLE, "position", "rad"), column("b", factor * SPEED, "velocity")]
    found = with_velocities_found(channels, 1 / RATE)[1]
    assert (found.unit, found.sign) == (unit, int(np.sign(factor)))


@pytest.mark.parametrize(
    ("turns", "speed", "units"),
    [
        (1 / (2 * np.pi), 30 / np.pi, ("rev", "rpm")),
        (180 / np.pi, 30 / np.pi, ("deg", "rpm")),
        (180 / np.pi, 1.0, ("deg", "rad/s")),
        (1.0, 180 / np.pi, ("rad", "deg/s")),
    ],
)
def test_a_speed_in_another_unit_tells_that_of_the_angle(turns, speed, units):
    """Neither column says its unit: 60 times the derivative are turns and rpm, whatever the range."""
    channels = [column("a", 24 * turns * ANGLE, "position"), column("b", 24 * speed * SPEED, "velocity")]
    found = with_velocities_found(with_motion_units(channels, None, 1 / RATE), 1 / RATE)
    assert tuple(c.unit for c in found) == units
    assert not any(c.doubt for c in found)


def test_a_velocity_of_no_known_unit_stays_open():
    channels = [column("a", ANGLE, "position", "rad"), column("b", 3.0 * SPEED, "velocity")]
    assert with_velocities_found(channels, 1 / RATE)[1].unit is None


def test_columns_without_names_are_told_by_how_they_move():
    """A joint's position, its speed, the reference that it follows, and a rough torque.

    Of a single sine, the reference would be its acceleration as well.
    """
    place = ANGLE + 0.3 * np.sin(2.9 * TIME)
    speed = SPEED + 0.3 * 2.9 * np.cos(2.9 * TIME)
    rough = np.random.default_rng(0).standard_normal(len(TIME))
    wanted = place + 1e-3 * np.sin(9 * TIME)
    columns = (place, speed, wanted, rough, np.full(len(TIME), 2.0))
    channels = [column(str(i), v, "unknown", joint=None) for i, v in enumerate(columns)]
    for robot in (one_joint(), None):
        found = nameless(channels, robot, 1 / RATE)
        assert [c.signal for c in found] == ["position", "velocity", "reference", "torque", "unknown"]
        assert [c.joint for c in found] == [1, 1, 1, 1, None]
    assert nameless(channels, None, None) == channels


def test_what_moves_like_a_named_position_is_its_reference():
    """Of another length over the same time, too; like two joints, it is neither's."""
    positions = [column("q1", ANGLE, "position", "rad"), column("q2", np.cos(3 * TIME), "position", "rad", 2)]
    free = column("x", ANGLE[::2] + 1e-3, "unknown", joint=None)
    found = nameless([*positions, free], None, 1 / RATE)[-1]
    assert (found.signal, found.joint) == ("reference", 1)
    both = [positions[0], replace(positions[1], values=2 * ANGLE), free]
    assert nameless(both, None, 1 / RATE)[-1].signal == "unknown"


def test_a_proposal_says_every_correction():
    """What stands in the file is what the channels say: sign, offset, delay, clock, drive, rate, header."""
    current = Channel("i1", TIME, 100.0, "current", 1, "motor", "A", -1, 0.25, 0.004, "t2", doubt="how much?")
    place = column("q1", ANGLE, "position", "rad")
    proposal = Proposal(("a.csv",), (current, place), 100.0, False, 1, (), ("how much?",))
    text = proposal.toml()
    assert "header = false\nrate = 100.0\n" in text
    assert re.search(
        r'# \? how much\?\n\[signals\."motor1\.current"\]\nsource = "i1"\nunit = "A"\nsign = -1\n'
        r'offset = 0\.25\ndelay = 0\.004\ntime = "t2"\ndrive = 1\.0',
        text,
    )
    unknown = replace(proposal, rate=None).toml()
    assert "# rate = NUMBER  # ? samples per second" in unknown
    assert "rate" not in tomllib.loads(unknown)  # which import refuses
    timed = replace(proposal, channels=(column("t", TIME, "time", "s", None), place))
    assert 'time = { source = "t", unit = "s" }' in timed.toml()


def test_a_gap_in_the_time_is_told_and_leaves_the_rate(tmp_path):
    time = np.where(np.arange(len(TIME)) < 900, TIME, TIME + 3.0)
    frame = pd.DataFrame({"t": time, "q1": ANGLE, "tau1": np.cos(9 * TIME)})
    frame.to_csv(tmp_path / "a.csv", index=False)
    found = inspect_log([tmp_path / "a.csv"], one_joint())
    assert any(note.startswith("t has a gap of 3") and "at row 901: cut" in note for note in found.notes)
    assert {round(c.rate, 6) for c in found.channels} == {RATE}


def test_no_file_is_one_sentence():
    with pytest.raises(LogError, match="there is no file; give one or more of one recording"):
        inspect_log([])


def test_columns_without_a_number_are_left_out_and_said(tmp_path):
    frame = pd.DataFrame({"t": TIME, "q1": ANGLE, "tau1": np.cos(9 * TIME), "void": np.nan, "wild": 1e200})
    frame.to_parquet(tmp_path / "a.parquet")
    found = inspect_log([tmp_path / "a.parquet"])
    assert "void is left out: it holds no number" in found.notes
    assert any(note.startswith("wild is left out: no sensor measures values beyond") for note in found.notes)


def test_two_columns_for_one_signal_and_a_joint_too_many_are_asked(tmp_path):
    frame = pd.DataFrame(
        {"t": TIME, "q_1": ANGLE, "joint1.position": 1.1 * ANGLE, "q_2": ANGLE**3, "tau_1": np.cos(9 * TIME)}
    )
    frame.to_csv(tmp_path / "a.csv", index=False)
    found = inspect_log([tmp_path / "a.csv"], one_joint())
    assert any("both look like joint1.e" in question for question in found.questions)
    second = next(c for c in found.channels if c.column == "q_2")
    assert second.name is None


def test_joints_without_a_torque_are_asked(tmp_path):
    frame = pd.DataFrame({"t": TIME, "q_1": ANGLE})
    frame.to_csv(tmp_path / "a.csv", index=False)
    asked = inspect_log([tmp_path / "a.csv"], one_joint()).questions
    assert any(question.startswith("no column looks like a torque") for question in asked)


def test_files_of_one_recording_are_read_together(tmp_path):
    """Columns of several files carry their file's name where they would be mistaken for each other."""
    for name, values in (("left", ANGLE), ("right", ANGLE**3)):
        pd.DataFrame({"t": TIME, "q_1": values}).to_csv(tmp_path / f"{name}.csv", index=False)
    found = inspect_log([tmp_path / "left.csv", tmp_path / "right.csv"], load_robot("tx40"))
    columns = [c.column for c in found.channels]
    assert len(columns) == len(set(columns)) == 4


def test_a_bus_that_answers_when_it_can_has_an_uneven_clock_and_a_switch(tmp_path):
    steps = np.random.default_rng(3).choice([0.004, 0.005, 0.009], len(ANGLE))
    columns = {"position": ANGLE, "goal_position": 1.1 * ANGLE, "timestamp": np.cumsum(steps)}
    pd.DataFrame(columns | {"torque_enable": TIME[-1] / 2 > TIME}).to_csv(tmp_path / "bus.csv", index=False)
    found = inspect_log([tmp_path / "bus.csv"])
    named = {c.column: (c.name, c.sure) for c in found.channels}
    assert named["timestamp"] == ("time", True)
    assert named["torque_enable"] == ("joint1.on", True)
    assert found.mapping.signals["joint1.on"].column == "torque_enable"


def test_a_switch_of_more_than_two_places_is_none(tmp_path):
    columns = {"t": TIME, "position": ANGLE, "torque_enable": np.arange(len(TIME)) % 3}
    pd.DataFrame(columns).to_csv(tmp_path / "bus.csv", index=False)
    assert {c.column: c.name for c in inspect_log([tmp_path / "bus.csv"]).channels}["torque_enable"] is None


def test_recordings_with_the_same_columns_share_one_mapping(tmp_path):
    """As `identify` takes them: each holds every joint, so that they are repetitions, not parts."""
    files = [tmp_path / f"run{i}.csv" for i in (1, 2, 3)]
    for i, file in enumerate(files, start=1):
        columns = {"time": TIME, "joint1.q [rad]": ANGLE * i, "joint1.tau [N.m]": np.gradient(ANGLE) / i}
        pd.DataFrame(columns).to_csv(file, index=False)
    alone, found = inspect_log(files[:1], one_joint()), inspect_log(files, one_joint())
    assert [c.column for c in found.channels] == [c.column for c in alone.channels]
    assert found.mapping == alone.mapping
    assert found.files == tuple(map(str, files))
    assert "same columns" in found.notes[0]


def test_friction_fits_any_gear_and_answers_for_none(tmp_path):
    """Motor columns of a joint with a gear of 50: viscous and dry friction explain them as they stand."""
    log = analytic_log(seconds=30.0, period=0.01).frame
    columns = {"time": log["time"], "motor_angle [deg]": np.degrees(50 * log["joint1.e"])}
    pd.DataFrame(columns | {"motor_torque [N.m]": log["joint1.tau"] / 50}).to_csv(
        tmp_path / "a.csv", index=False
    )
    asked = inspect_log([tmp_path / "a.csv"], free_joint()).questions
    assert len(asked) == 2
    assert "motor_angle is called that of a motor" in asked[0]
    assert "motor_torque makes the masses" in asked[1]
    assert "gear ratio" in asked[1]


@pytest.mark.parametrize(("driven", "asked"), [(True, False), (False, True)])
def test_a_servo_needs_no_column_of_torque(driven, asked, tmp_path):
    none = (0.0,)
    servo = Servo(1000.0, 7.4, (1.0,), (2.0,), (1.2,), (3.4,), none, none, (1.0,), none, none)
    robot = replace(free_joint(), servo=servo) if driven else free_joint()
    pd.DataFrame({"t": TIME, "goal_position": ANGLE, "present_position": 0.9 * ANGLE}).to_csv(
        tmp_path / "a.csv", index=False
    )
    questions = inspect_log([tmp_path / "a.csv"], robot).questions
    assert any("torque" in question for question in questions) == asked


def test_deformations_under_their_own_names_are_taken_as_they_are(tmp_path):
    """A proposal that leaves them out makes a robot whose hinges nobody logged."""
    time = np.arange(0, 4, 0.01)
    e = np.sin(time)
    table = {"time": time, "joint1.e": e, "joint1.eps[1]": 1e-3 * np.cos(time), "joint1.tau": 20 * np.cos(e)}
    pd.DataFrame(table).to_csv(tmp_path / "a.csv", index=False)
    found = inspect_log([tmp_path / "a.csv"])
    assert not any("eps" in question for question in found.questions)
    log = import_log([tmp_path / "a.csv"], found.mapping)
    np.testing.assert_allclose(log.frame["joint1.eps[1]"], table["joint1.eps[1]"], atol=1e-12)
