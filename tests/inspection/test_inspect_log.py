"""A mapping is found for a dozen styles of files; what cannot be known is asked, never asserted."""

import json

import h5py
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from inspection.more_styles import counts, named_arm, nested_groups, spreadsheet
from inspection.other_tools import TOOLS, turns
from inspection.styles import STYLES, arm, plain_csv, shuffled_parquet, sound

from flexmodels.files.robot_file import save_robot
from pyident.cli.main import main
from pyident.inspection.inspect_log import inspect_log
from pyident.inspection.words import meaning
from pyident.logs.foreign import import_log
from pyident.logs.mapping import read_mapping

pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes the recording")
SHARE = 0.9  # of the columns that must be right


@pytest.fixture(scope="module")
def recording():
    return sound()


@pytest.fixture(scope="module")
def robot():
    return arm()


@pytest.mark.parametrize(
    "style", [*STYLES, spreadsheet, named_arm, nested_groups, *TOOLS], ids=lambda style: style.__name__
)
def test_a_mapping_is_proposed_and_nothing_wrong_asserted(style, recording, robot, tmp_path):
    pytest.importorskip(
        "h5py" if style.__name__ in ("mat_7_3", "hdf5_two_rates", "nested_groups") else "numpy"
    )
    pytest.importorskip("rosbags" if style.__name__ in ("mcap", "named_arm") else "numpy")
    made = style(recording, tmp_path)
    found = inspect_log([made.path], robot)
    guesses = {c.column: c for c in found.channels}
    assert set(made.truth) <= set(guesses)
    right, asserted = 0, []
    for column, truth in made.truth.items():
        c = guesses[column]
        said = None if c.name is None else (c.name, c.unit or "1", c.sign, round(c.offset, 3))
        right += said == truth
        if said != truth and not c.doubt:
            asserted.append((column, said, truth))
    assert not asserted
    assert right >= SHARE * len(made.truth)
    assert all(guesses[column].doubt for column in made.asked)
    assert len(found.questions) == sum(bool(c.doubt) for c in found.channels)


@pytest.mark.parametrize("known", [True, False], ids=["robot", "no robot"])
def test_what_only_its_place_tells_is_asked(known, recording, robot, tmp_path):
    made = counts(recording, tmp_path)
    found = inspect_log([made.path], robot if known else None)
    for c in found.channels:
        assert c.column not in made.asked or c.doubt or c.name is None, c
        assert c.column in made.asked or c.name == "time"
    assert found.questions


@pytest.mark.parametrize(
    "style", [spreadsheet, named_arm, nested_groups, *TOOLS], ids=lambda style: style.__name__
)
def test_nothing_wrong_is_asserted_of_an_unknown_robot(style, recording, tmp_path):
    pytest.importorskip({"named_arm": "rosbags", "nested_groups": "h5py"}.get(style.__name__, "numpy"))
    made = style(recording, tmp_path)
    for c in inspect_log([made.path]).channels:
        truth = made.truth.get(c.column)
        assert c.doubt or c.name is None or (truth is not None and c.name == truth[0]), c


def test_a_column_that_only_moves_like_a_joint_is_asked(recording, tmp_path):
    columns = recording[["time", "q1", "q2"]].assign(elbow=recording["q2"].round(4))
    columns.to_csv(tmp_path / "copy.csv", index=False)
    guesses = {c.column: c for c in inspect_log([tmp_path / "copy.csv"]).channels}
    assert guesses["elbow"].name == "joint2.r"
    assert guesses["elbow"].doubt == "is elbow the reference of joint 2? it moves alike, no name says so"


def test_a_supply_is_no_drive(tmp_path):
    """A duty beside a battery's voltage: the duty is asked about, the battery is left out."""
    t = np.arange(0, 5, 0.01)
    columns = {"time": t, "id1_q": np.sin(t), "id1_voltage": 12 + 0.1 * np.cos(t), "id1_pwm": 300 * np.cos(t)}
    pd.DataFrame(columns).to_csv(tmp_path / "servo.csv", index=False)
    guesses = {c.column: c for c in inspect_log([tmp_path / "servo.csv"]).channels}
    assert guesses["id1_voltage"].name is None
    assert guesses["id1_voltage"].doubt == ""
    assert guesses["id1_pwm"].name == "joint1.tau"
    assert "[servo]" in guesses["id1_pwm"].doubt


def test_turns_are_not_called_radians(recording, tmp_path):
    """Without a robot nothing can tell them; with one, its weight does (above)."""
    found = inspect_log([turns(recording, tmp_path).path])
    assert "is trace.axis2.ActPos in radians or turns?" in " ".join(found.questions)


def test_what_is_written_is_what_import_reads(recording, robot, tmp_path):
    made = shuffled_parquet(recording, tmp_path)
    save_robot(robot, tmp_path / "arm.toml")
    words = ["log", "inspect", made.path, "--robot", tmp_path / "arm.toml", "-o", tmp_path / "mapping.toml"]
    done = CliRunner().invoke(main, [str(w) for w in [*words, "--json", tmp_path / "found.json"]])
    assert done.exit_code == 0, done.output
    assert "ActualTorque3" in done.output
    told = json.loads((tmp_path / "found.json").read_text())
    assert told["questions"] == []
    log = import_log([made.path], read_mapping(tmp_path / "mapping.toml"), robot)
    for k in range(1, 7):
        np.testing.assert_allclose(log.frame[f"joint{k}.tau"], recording[f"tau{k}"], rtol=1e-9)
        np.testing.assert_allclose(log.frame[f"joint{k}.e"], recording[f"q{k}"], rtol=1e-12)


def test_without_a_robot_units_of_torques_are_asked(recording, tmp_path):
    found = inspect_log([plain_csv(recording, tmp_path).path])
    guesses = {c.column: c for c in found.channels}
    assert guesses["q_3"].name == "joint3.e"
    assert guesses["q_3"].sure
    assert not guesses["tau_3"].sure
    assert any("unit of tau_3" in q for q in found.questions)
    assert "# ? " in found.toml()


def test_a_file_without_time_or_torque_is_questioned(recording, robot, tmp_path):
    recording[[f"q{k}" for k in range(1, 7)]].to_csv(tmp_path / "bare.csv", index=False)
    done = CliRunner().invoke(main, ["log", "inspect", str(tmp_path / "bare.csv")])
    assert done.exit_code == 1
    assert "how many samples a second" in done.output
    assert "no column looks like the torque of joint 1" in done.output


def test_the_rate_is_in_the_unit_of_the_time(tmp_path):
    """A clock in ms with steps of 2 is 500 Hz, not 0.5."""
    time = np.arange(0, 2000, 2)
    pd.DataFrame({"Zeit [ms]": time, "A1 Winkel [Grad]": 40 * np.sin(time / 300)}).to_csv(
        tmp_path / "a.csv", index=False
    )
    found = inspect_log([tmp_path / "a.csv"])
    assert [channel.rate for channel in found.channels] == pytest.approx([500.0, 500.0])


def test_the_rate_of_a_column_is_that_of_its_own_clock(tmp_path):
    fast, slow = np.arange(0, 2, 0.001), np.arange(0, 2, 0.0025)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.update({"fast/time": fast, "fast/q1": np.sin(fast), "odd/current1": np.cos(slow[::7])})
        file.update({"slow/time": slow, "slow/torque1": np.cos(slow)})
    found = inspect_log([tmp_path / "a.h5"])
    rates = {channel.column: channel.rate for channel in found.channels}
    assert np.isnan(rates["odd/current1"])  # no clock is as long
    for name, at in (("fast/time", 1000), ("fast/q1", 1000), ("slow/time", 400), ("slow/torque1", 400)):
        assert rates[name] == pytest.approx(at)


@pytest.mark.parametrize(
    ("name", "signal", "joint", "unit"),
    [
        ("actual_q_0", "position", 0, None),
        ("joint_3.position", "position", 3, None),
        ("target_q_5", "reference", 5, None),
        ("Soll_A2_deg", "reference", 2, "deg"),
        ("tau_ff_1", "feedforward", 1, None),
        ("i_q_4", "current", 4, None),
        ("motor2_temperature", "other", 2, None),
        ("qdd3", "acceleration", 3, None),
        ("dq2", "velocity", 2, None),
        ("time_ms", "time", None, "ms"),
        ("A1 Motorwinkel", "position", 1, None),
        ("A2 Motorstrom", "current", 2, None),
        ("Antriebsmoment_4", "torque", 4, None),
        ("A3 Hub", "position", 3, None),
        ("load_pos_mm", "position", None, "mm"),
        ("load_1", "torque", 1, None),
        ("link_deg", "position", None, "deg"),
        ("motor_current_A", "current", None, "A"),
        ("qfrc_actuator_2", "torque", 2, None),
        ("actuator_force_1", "torque", 1, None),
        ("qfrc_bias_2", "other", 2, None),
        ("robot0_eef_pos[1]", "other", 1, None),
        ("cartesian_position_3", "other", 3, None),
        ("speed_scaling_1", "other", 1, None),
    ],
)
def test_names_are_understood(name, signal, joint, unit):
    found = meaning(name)
    assert (found.signal, found.unit) == (signal, unit)
    assert found.joint in (joint, None) if joint is None else found.joint == joint


@pytest.mark.parametrize(
    ("pattern", "numbers"), [("joint{}.pos_deg", (10, 2, 1)), ("id{}_position_deg", (21, 3, 12))]
)
def test_numbers_that_are_no_joints_from_one_on_are_taken_in_their_order_and_asked(
    pattern, numbers, recording, tmp_path
):
    """A bus's ids, in any order of the columns: 1, 2, 10, not 1, 10, 2, and not ten joints."""
    angles = {pattern.format(j): np.rad2deg(recording[f"q{k}"]) for k, j in enumerate(numbers, start=1)}
    pd.DataFrame({"time": recording["time"]} | angles).to_csv(tmp_path / "bus.csv", index=False)
    found = inspect_log([tmp_path / "bus.csv"])
    guesses = {c.column: c for c in found.channels}
    assert found.joints == 3
    for place, number in enumerate(sorted(numbers), start=1):
        column = pattern.format(number)
        assert guesses[column].name == f"joint{place}.e"
        asked = f"is {column} really joint{place}.e? only the order of the numbers in the names says so"
        assert asked in found.questions


def test_ids_of_a_bus_that_a_robots_equations_confirm_are_not_asked(recording, robot, tmp_path):
    ids = {f"id{10 + k}_{word}": recording[f"{a}{k}"] for k in range(6, 0, -1)
           for word, a in (("q", "q"), ("torque", "tau"))}  # fmt: skip
    pd.DataFrame({"time": recording["time"]} | ids).to_csv(tmp_path / "bus.csv", index=False)
    found = inspect_log([tmp_path / "bus.csv"], robot)
    names = {c.column: c.name for c in found.channels}
    assert names == {"time": "time"} | {
        f"id{10 + k}_{word}": f"joint{k}.{a}"
        for k in range(1, 7)
        for word, a in (("q", "e"), ("torque", "tau"))
    }
    assert found.questions == ()


def test_words_that_differ_in_a_number_come_in_its_order(recording, tmp_path):
    names = ("shoulder", "elbow", "wrist_10", "wrist_2")
    angles = {f"{name}.position": recording[f"q{k}"] for k, name in enumerate(names, start=1)}
    pd.DataFrame({"time": recording["time"]} | angles).to_csv(tmp_path / "words.csv", index=False)
    guesses = {c.column: c for c in inspect_log([tmp_path / "words.csv"]).channels}
    places = ("shoulder", "elbow", "wrist_2", "wrist_10")
    for place, name in enumerate(places, start=1):
        c = guesses[f"{name}.position"]
        assert c.name == f"joint{place}.e"
        assert "only the order of names without numbers says so" in c.doubt


def test_messages_that_a_terminal_wrote_without_header_are_read(recording, tmp_path):
    """`ros2 topic echo --csv`: stamp, frame, names, positions, velocities, efforts of each message."""
    names = ["elbow", "shoulder", "base"]
    lines = []
    for _, row in recording.iterrows():
        whole = round(1e9 * row["time"]) + 1_700_000_000_900_000_000
        values = [row[f"{a}{k}"] for a in ("q", "dq", "tau") for k in (3, 2, 1)]
        head = [whole // 10**9, whole % 10**9, "", *names]
        lines.append(",".join(str(v) for v in (*head, *values)))
    (tmp_path / "echo.csv").write_text("\n".join(lines) + "\n")
    found = inspect_log([tmp_path / "echo.csv"])
    guesses = {c.column: c for c in found.channels}
    np.testing.assert_allclose(
        guesses["stamp"].values - guesses["stamp"].values[0], recording["time"], atol=1e-6
    )
    for place, (name, k) in enumerate(zip(names, (3, 2, 1), strict=True), start=1):
        np.testing.assert_array_equal(guesses[f"{name}.position"].values, recording[f"q{k}"])
        assert guesses[f"{name}.position"].name == f"joint{place}.e"
        assert guesses[f"{name}.effort"].name == f"joint{place}.tau"
        assert guesses[f"{name}.velocity"].name is None
        assert guesses[f"{name}.position"].doubt
    (tmp_path / "mapping.toml").write_text(found.toml())
    log = import_log([tmp_path / "echo.csv"], read_mapping(tmp_path / "mapping.toml"))
    np.testing.assert_allclose(log.frame["joint3.e"], recording["q1"])
