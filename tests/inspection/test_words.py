"""What the words of a name and its unit say."""

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint

from pyident.inspection.inspect_log import inspect_log
from pyident.inspection.words import in_unit, meaning


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("current_mA_crane_x7_joint1", "mA"),
        ("position_deg_joint2", "deg"),
        ("position_in_rad_1", "rad"),  # no inches
        ("position_1", None),
        ("pan_trq_mNm", "mN.m"),  # capitals tell it from N.m
        ("trq1_kNm", "kN.m"),
    ],
)
def test_a_unit_may_stand_behind_the_signal_and_before_the_joint(name, unit):
    assert meaning(name).unit == unit


def test_the_address_of_an_object_is_no_joint():
    found = [
        meaning(f"Axis{k} 0x{what}") for k in (1, 2) for what in ("6064 Position actual value", "6077 Torque")
    ]
    assert [(m.joint, m.signal) for m in found] == [
        (1, "position"),
        (1, "torque"),
        (2, "position"),
        (2, "torque"),
    ]


@pytest.mark.parametrize("column", ["F1 [Nm]", "Kraftaufnehmer 1 [N.m]"])
def test_what_is_measured_in_newtons_at_a_joint_is_its_torque(column, tmp_path):
    time = 0.01 * np.arange(1000)
    columns = {"t": time, "q1": np.sin(time), column: 3 * np.cos(2 * time)}
    pd.DataFrame(columns).to_csv(tmp_path / "log.csv", index=False)
    found = inspect_log([tmp_path / "log.csv"], one_joint())
    assert {c.name for c in found.channels if c.signal == "torque"} == {"joint1.tau"}


@pytest.mark.parametrize(
    ("name", "signal", "joint"),
    [
        ("axisQMsr_LBR_iiwa_7_R800_1[0]", "position", 0),
        ("axisQCmdT1m_LBR_iiwa_7_R800_1[3]", "reference", 3),
        ("axisTauMsr_LBR_iiwa_7_R800_1[6]", "torque", 6),
        ("KR_R1300_A2_soll", "reference", 2),
        ("q_r2", "reference", 2),
        ("r101", "reference", 101),  # of a bus, and no type
        ("m2_q", "position", 2),
        ("m2", "torque", 2),
        ("current_q1", "position", 1),
        ("current_angle_deg", "position", None),
        ("CurrentVelocity1", "velocity", 1),
        ("current1", "current", 1),
        ("motor_current_1", "current", 1),
        ("Target Joint Moments_0", "torque", 0),
        ("measured_tq_0", "torque", 0),
        ("joint1_eff", "torque", 1),
        ("PosDiff", "other", "diff"),
        ("finger_d_position", "position", "finger_d"),
        ("q_d_1", "reference", 1),
        ("et1", "other", 1),
    ],
)
def test_the_type_of_a_robot_and_the_letter_of_its_motor_are_no_signals(name, signal, joint):
    assert (meaning(name).signal, meaning(name).joint) == (signal, joint)


@pytest.mark.parametrize(
    ("name", "signal"),
    [
        ("j1_deg", "position"),
        ("joint_1_rad", "position"),
        ("axis1 [deg]", "position"),
        ("j1_deg/s", "velocity"),
        ("J1_Nm", "torque"),
        ("temperature_1_deg", "other"),
        ("roll_1_deg", "unknown"),
        ("yaw_deg", "unknown"),
    ],
)
def test_a_joint_with_a_unit_says_what_is_measured(name, signal):
    assert meaning(name).signal == signal


def inspected(folder, **columns):
    time = 0.01 * np.arange(400)
    pd.DataFrame({"time": time} | columns).to_csv(folder / "log.csv", index=False)
    return inspect_log([folder / "log.csv"])


MOVES = {k: np.sin((1 + 0.3 * k) * 0.01 * np.arange(400)) for k in range(1, 5)}


def test_the_present_load_of_a_servo_is_a_duty():
    assert meaning("present_load").signal == "voltage"
    assert meaning("joint1_load").signal == "torque"


def test_points_beside_joints_are_no_joints(tmp_path):
    tips = {
        pattern.format(letter): 0.3 * MOVES[k]
        for pattern in ("{}_m", "pos_{}", "robot_{}", "model_r{}")
        for k, letter in enumerate("xyz", start=1)
    }
    found = inspected(tmp_path, **tips, **{f"j{k}_deg": 60 * x for k, x in MOVES.items()})
    assert {c.name for c in found.channels} == {"time", None, *(f"joint{k}.e" for k in MOVES)}
    assert not any(c.name for c in found.channels if c.column in tips)


@pytest.mark.parametrize("names", [("e0", "e1", "s0", "s1", "w0", "w1", "w2"), tuple("bltusr")])
def test_letters_of_axes_are_no_signals(names, tmp_path):
    columns = [f"left_{name}" for name in names]
    found = inspected(tmp_path, **{c: (1 + i) * MOVES[1 + i % 4] for i, c in enumerate(columns)})
    assert not any(c.name for c in found.channels if c.column in columns)
    assert any("no column looks like the position of a joint" in question for question in found.questions)
    ended = [f"{c}_pos" for c in columns]
    found = inspected(tmp_path, **{c: (1 + i) * MOVES[1 + i % 4] for i, c in enumerate(ended)})
    assert {c.column: c.name for c in found.channels if c.name != "time"} == {
        c: f"joint{k}.e" for k, c in enumerate(ended, start=1)
    }


def test_letters_of_signals_stay_these(tmp_path):
    found = inspected(tmp_path, motor_q=MOVES[1], motor_v=MOVES[2], motor_i=MOVES[3], motor_k=MOVES[4])
    assert {c.column: c.signal for c in found.channels}["motor_i"] == "current"


def test_a_name_that_comes_twice_is_of_the_same_joint(tmp_path):
    table = np.column_stack([0.01 * np.arange(400), MOVES[1], MOVES[2], MOVES[1], MOVES[3]])
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header="time,q[0],q[1],q[0],q[1]", comments="")
    found = inspect_log([tmp_path / "log.csv"])
    names = {c.column: c.name for c in found.channels}
    assert (names["q[0]"], names["q[1]"]) == ("joint1.e", "joint2.e")
    assert names["q[0] (2)"] is names["q[1] (2)"] is None
    asked = [question for question in found.questions if "both look like" in question]
    assert asked == ["q[1] (2) and q[1] both look like joint2.e: q[1] is taken; is that right?"]


def test_the_same_angle_in_another_unit_is_not_asked(tmp_path):
    degrees = {f"j{k}_deg": np.round(np.rad2deg(x), 2) for k, x in MOVES.items()}
    found = inspected(tmp_path, **{f"j{k}_rad": x for k, x in MOVES.items()}, **degrees)
    assert not any("both look like" in question for question in found.questions)
    assert [c.column for c in found.channels if c.signal == "position"] == [f"j{k}_rad" for k in MOVES]


def test_the_joint_behind_a_link_is_no_encoder_of_the_link():
    assert meaning("arm_link_joint.position").side == "joint"
    assert meaning("link1_position").side == "link"


def test_a_unit_beside_the_name_tells_what_is_measured_of_a_motor():
    motor, link = (in_unit(meaning(name), "deg") for name in ("A2.Motor", "A1.Abtrieb"))
    assert (motor.signal, motor.joint, motor.side, motor.unit) == ("position", 2, "motor", "deg")
    assert (link.signal, link.joint, link.side) == ("position", 1, "link")
    assert in_unit(meaning("A1.Motor"), None).signal == "unknown"
