"""What names, ranges and jumps leave open is asked, in the words in which the mapping is read."""

import json
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from inspection.styles import arm, sound
from one_joint import one_joint

from flexmodels.gearing import Transmission
from pyident.inspection.inspect_log import inspect_log
from pyident.logs.foreign import import_log
from pyident.logs.log import LogError
from pyident.logs.mapping import read_mapping

TIME = np.arange(400) * 0.01
ANGLE = np.sin(TIME)


def inspected(folder, **columns):
    pd.DataFrame({"time_s": TIME, "q1_rad": ANGLE} | columns).to_csv(folder / "raw.csv", index=False)
    return inspect_log([folder / "raw.csv"])


@pytest.mark.parametrize(
    ("column", "values", "asked", "line"),
    [
        ("motor_current_1 [%]", 40 * ANGLE, "are 100 % of motor_current_1", "rated = 1.0  # ? A at 100 %"),
        (
            "torque_1 [%]",
            40 * ANGLE,
            "N m (or N) are 100 % of torque_1",
            "rated = 1.0  # ? N m (or N) at 100 %",
        ),
        (
            "X1.Torque actual value [0.1%]",
            400 * ANGLE,
            "N m (or N) are 100 % of X1.Torque actual value",
            "rated = 1.0  # ? N m (or N) at 100 %",
        ),
        (
            "Drehmomentistwert Achse_1 [%]",
            40 * ANGLE,
            "N m (or N) are 100 % of Drehmomentistwert Achse_1",
            "rated = 1.0  # ? N m (or N) at 100 %",
        ),
        ("current_1 [mA]", 900 * ANGLE, "does one A of current_1 give", "drive = 1.0  # ? N m (or N) per A"),
        (
            "current_1",
            np.round(90 * ANGLE),
            "does one count of current_1",
            "drive = 1.0  # ? N m (or N) per count",
        ),
        (
            "current_1",
            3.3 * ANGLE,
            "does one unit of current_1",
            "drive = 1.0  # ? N m (or N) per unit of the",
        ),
        ("volt_1 [mV]", 900 * ANGLE, "does one V give", "drive = 1.0  # ? N m (or N) per V"),
    ],
)
def test_the_question_of_a_drive_is_in_the_unit_of_its_answer(column, values, asked, line, tmp_path):
    """What is answered with 3 comes out as 3 N m per what was asked for."""
    found = inspected(tmp_path, **{column: values})
    assert asked in " ".join(found.questions)
    assert line in found.toml()
    (tmp_path / "m.toml").write_text(re.sub("(drive|rated) = 1.0", r"\1 = 3", found.toml()))
    frame = import_log([tmp_path / "raw.csv"], read_mapping(tmp_path / "m.toml")).frame
    per = {"%": 0.01, "0.1%": 0.001, "mA": 1e-3, "mV": 1e-3}.get(column.partition("[")[2].strip("]"), 1.0)
    effort = next(name for name in frame if name.endswith((".tau", ".current")))
    assert frame[effort].to_numpy() == pytest.approx(3 * per * values)


def test_a_commanded_torque_is_asked_and_comes_after_every_measured_one(tmp_path):
    found = inspected(tmp_path, target_moment_1=3 * ANGLE)
    assert "target_moment_1 was commanded, not measured" in " ".join(found.questions)
    found = inspected(tmp_path, target_moment_1=3 * ANGLE, actual_current_1=ANGLE)
    names = {c.column: c.name for c in found.channels}
    assert names["actual_current_1"] == "joint1.tau"
    assert names["target_moment_1"] is None


@pytest.mark.parametrize(("unit", "turn"), [("rad", 2 * np.pi), ("deg", 360.0)])
def test_a_wrapped_angle_is_joined(unit, turn, tmp_path):
    angle = turn * (0.4 + 0.3 * np.sin(2 * TIME))
    wrapped = (angle + turn / 2) % turn - turn / 2
    found = inspected(tmp_path, q1_rad=0 * TIME, q2=wrapped)
    assert "q2 jumps by whole turns: unwrap = true joins it" in found.notes
    channel = next(c for c in found.channels if c.column == "q2")
    assert (channel.unit, channel.sure) == (unit, True)
    (tmp_path / "m.toml").write_text(found.toml())
    joined = import_log([tmp_path / "raw.csv"], read_mapping(tmp_path / "m.toml"))
    assert joined.frame["joint2.e"].to_numpy() == pytest.approx(angle * 2 * np.pi / turn)
    (tmp_path / "m.toml").write_text(found.toml().replace("unwrap = true\n", ""))
    left = import_log([tmp_path / "raw.csv"], read_mapping(tmp_path / "m.toml"))
    assert "q2 jumps by whole turns; unwrap = true in the mapping of joint2.e joins it" in left.notes


def test_an_angle_that_jumps_otherwise_is_left_alone(tmp_path):
    steps = np.where(TIME > 2, np.pi, 0.0) + 0.1 * ANGLE
    noisy = np.pi * np.random.default_rng(0).uniform(-1, 1, len(TIME))
    found = inspected(tmp_path, q2=steps, q3=noisy)
    assert "unwrap" not in found.toml()


@pytest.mark.parametrize("scale", [1.0, 0.8])
def test_degrees_are_told_from_parts_of_a_range_by_the_equations(scale, tmp_path):
    recording = sound()
    named = {f"pos_{k}": scale * np.rad2deg(recording[f"q{k}"]) for k in range(1, 7)}
    torques = {f"tau_{k}": recording[f"tau{k}"] for k in range(1, 7)}
    frame = pd.DataFrame({"time": recording["time"]} | named | torques)
    frame.to_csv(tmp_path / "raw.csv", index=False)
    alone = inspect_log([tmp_path / "raw.csv"])
    known = inspect_log([tmp_path / "raw.csv"], arm())
    parts = "or in parts of its range from -100 to 100"
    assert sum(parts in question for question in alone.questions) == 6
    assert sum(parts in question for question in known.questions) == (0 if scale == 1 else 6)


def test_the_mapping_is_written_also_where_nobody_reads_on(tmp_path):
    pd.DataFrame({"time": TIME} | {f"temperature_{i}": TIME * i for i in range(1500)}).to_csv(
        tmp_path / "raw.csv", index=False
    )
    words = [sys.executable, "-m", "pyident", "log", "inspect", "raw.csv", "-o", "m.toml", "--json", "m.json"]
    run = subprocess.Popen(
        words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1
    )
    assert run.stdout is not None
    assert run.stderr is not None
    assert run.stdout.readline().startswith("time")
    run.stdout.close()
    assert run.stderr.read() == ""
    run.stderr.close()
    assert run.wait() == 1  # questions are open
    assert "joints = 1" in (tmp_path / "m.toml").read_text()
    assert json.loads((tmp_path / "m.json").read_text())["questions"]


def test_a_note_on_a_turned_sign_does_not_ask_for_it_again(tmp_path):
    recording = sound()
    recording[["q3", "tau3"]] *= -1
    kept = ["time", *(f"{a}{k}" for a in ("q", "tau") for k in range(1, 7))]
    recording[kept].to_csv(tmp_path / "raw.csv", index=False)
    found = inspect_log([tmp_path / "raw.csv"], arm())
    assert any("joint3.tau with the other sign fits; the mapping has it" in note for note in found.notes)
    assert found.toml().count("sign = -1") == 2


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (TIME[::-1], "time_s goes back from 3.99 to 3.98 at row 2"),
        (0 * TIME, "time_s holds one time in 400 rows, as if digits were cut off"),
    ],
)
def test_a_time_that_is_none_is_told(time, words, tmp_path):
    asked = inspected(tmp_path, time_s=time).questions
    assert any(question.startswith(f"{words}: how many samples a second") for question in asked)


def test_files_of_two_rates_keep_their_clocks(tmp_path):
    pd.DataFrame({"time": TIME, "q1_rad": ANGLE}).to_csv(tmp_path / "pos.csv", index=False)
    pd.DataFrame({"time": TIME, "tau1_Nm": ANGLE}).iloc[::2].to_csv(tmp_path / "tau.csv", index=False)
    files = [tmp_path / "pos.csv", tmp_path / "tau.csv"]
    (tmp_path / "map.toml").write_text(inspect_log(files).toml())
    log = import_log(files, read_mapping(tmp_path / "map.toml"))
    assert log.frame["joint1.tau"].to_numpy() == pytest.approx(np.sin(log.frame["time"]), abs=1e-4)


def test_a_unit_that_the_file_gives_stands_where_masses_are_a_little_off(tmp_path):
    """A kgf cm is 0.87 lbf in, and so much lighter are the bodies in the robot's file."""
    f, robot = sound(), arm()
    columns = {"time": f["time"]} | {f"q{k}": f[f"q{k}"] for k in range(1, 7)}
    columns |= {f"tau{k} [lbf.in]": f[f"tau{k}"] / 0.112985 for k in range(1, 7)}
    pd.DataFrame(columns).to_csv(tmp_path / "raw.csv", index=False)
    light = {name: 0.87 * value for name, value in robot.parameters.items() if name.startswith("link")}
    found = inspect_log([tmp_path / "raw.csv"], robot.with_parameters(light))
    assert {c.unit for c in found.channels if c.signal == "torque"} == {"lbf.in"}
    assert not any("which is right" in question for question in found.questions)


def test_a_signal_that_names_no_joint_is_asked_for_it(tmp_path):
    """And the mapping that holds nothing yet says what it is to hold."""
    columns = {"t": TIME, "theta": ANGLE, "alpha": 2 * ANGLE, "tau_theta": 3 * ANGLE}
    pd.DataFrame(columns).to_csv(tmp_path / "raw.csv", index=False)
    found = inspect_log([tmp_path / "raw.csv"], arm())
    assert found.questions == (
        "theta looks like a position, but of which joint? no name says so; 6 positions are needed",
        "tau_theta looks like a torque, but of which joint? no name says so; 6 torques are needed",
    )
    (tmp_path / "m.toml").write_text(found.toml())
    with pytest.raises(LogError, match=r'it maps no column; give each its table, \[signals."joint1.e"\]'):
        read_mapping(tmp_path / "m.toml")
    (tmp_path / "m.toml").write_text(found.toml().replace("# [", "[").replace("# source", "source"))
    assert read_mapping(tmp_path / "m.toml").signals["joint1.e"].column == "COLUMN"


def test_a_drive_that_the_robot_file_gives_is_not_asked(tmp_path):
    time = 0.01 * np.arange(400)
    columns = {"t": time, "motor1_angle_rad": 90 * np.sin(time), "motor1_current_A": -3 * np.sin(time)}
    pd.DataFrame(columns).to_csv(tmp_path / "log.csv", index=False)
    robot = replace(one_joint(), transmission=Transmission(((100.0,),), (0.0,), (0.5,)))
    found = inspect_log([tmp_path / "log.csv"], robot)
    assert not any("(drive, gear)" in question for question in found.questions)
    assert "drive =" not in found.toml()
    assert any("(drive, gear)" in question for question in inspect_log([tmp_path / "log.csv"]).questions)


@pytest.mark.parametrize(("turns", "asked"), [(1.5, False), (24.0, True)])
def test_an_angle_of_many_turns_is_asked_for_its_gear(turns, asked, tmp_path):
    degrees = 180 * turns * np.sin(TIME)
    pd.DataFrame({"time_s": TIME, "q1_deg": degrees, "tau1_Nm": ANGLE}).to_csv(
        tmp_path / "a.csv", index=False
    )
    found = inspect_log([tmp_path / "a.csv"])
    assert any("q1_deg turns 21 times: is it the motor's" in q for q in found.questions) == asked
