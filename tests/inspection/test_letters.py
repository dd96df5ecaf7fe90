"""Axes that are called by letters."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from flexmodels.files.robot_file import load_robot
from pyident.checks.transformations import transformations
from pyident.inspection.channel import LETTERS
from pyident.inspection.inspect_log import inspect_log
from pyident.inspection.letters import lettered
from pyident.inspection.words import meaning

TIME = 0.005 * np.arange(2000)
JOINT = """
[[joint]]
kind = "{kind}"
name = "{name}"
origin = [0.0, 0.0, 0.0]
x = [{x}]
y = [{y}]
[[link]]
m = 9.0
com = [0.0, 0.0, 0.0]
J_com = [1.0, 1.0, 1.0]
"""
AXES = ("1.0, 0.0, 0.0", "0.0, 1.0, 0.0", "0.0, 0.0, 1.0")


def robot(folder, kind="prismatic", names=("", "", "")):
    """Three axes, one at right angles to the other."""
    joints = [
        JOINT.format(kind=kind, name=name, x=AXES[k], y=AXES[(k + 1) % 3]) for k, name in enumerate(names)
    ]
    (folder / "robot.toml").write_text('name = "three"\n' + "".join(joints))
    return load_robot(folder / "robot.toml")


@pytest.mark.parametrize(
    "columns",
    [
        ("X_Pos [mm]", "Y_Pos [mm]", "Z_Pos [mm]"),
        ("PosX", "PosY", "PosZ"),
        ("x", "y", "z"),
        ("Z_mm", "Y_mm", "X_mm"),
        ("X_act [mm]", "Y_act [mm]", "Z_act [mm]"),
        ("axis_a_position", "axis_b_position", "axis_c_position"),
    ],
)
def test_letters_are_taken_in_their_order_and_asked(columns, tmp_path):
    """Torques of chance: no equation confirms the order."""
    rng = np.random.default_rng(0)
    data = {"Zeit [s]": TIME} | {c: 300 * np.sin((k + 2) * TIME) for k, c in enumerate(columns)}
    pd.DataFrame(data | {f"Kraft_{a}": rng.normal(size=len(TIME)) for a in "UVW"}).to_csv(
        tmp_path / "log.csv", index=False
    )
    found = inspect_log([tmp_path / "log.csv"], robot(tmp_path))
    named = {c.column: c for c in found.channels if c.signal == "position"}
    for k, column in enumerate(sorted(c.partition(" ")[0] for c in columns), start=1):
        assert named[column].name == f"joint{k}.e"
        assert f"is {column} really joint{k}.e? only {LETTERS} says so" in named[column].doubt
    forces = {c.column: c.name for c in found.channels if c.column.startswith("Kraft")}
    assert forces == {f"Kraft_{a}": f"joint{k}.tau" for k, a in enumerate("UVW", start=1)}
    assert not any(question.startswith("no column") for question in found.questions)


def test_machine_tools_call_sliders_and_hinges_by_letters_of_their_own(tmp_path):
    """A gantry whose hinge C is its second joint, with the units of each at the ends of names."""
    made = robot(tmp_path)
    joints = (made.joints[0], replace(made.joints[1], kind="revolute"), made.joints[2])
    names = ("C_act_deg", "X_act_mm", "Z_act_mm", "X_cur_A", "Z_cur_A", "C_cur_A")
    found, guessed = lettered({name: meaning(name) for name in names}, replace(made, joints=joints))
    assert {name: m.joint for name, m in found.items()} == {
        "X_act_mm": 1, "C_act_deg": 2, "Z_act_mm": 3, "X_cur_A": 1, "C_cur_A": 2, "Z_cur_A": 3
    }  # fmt: skip
    assert (found["C_act_deg"].unit, found["Z_act_mm"].unit, guessed) == ("deg", "mm", set(names))


@pytest.mark.parametrize(
    ("names", "kind"),
    [
        (("x", "y", "z"), "revolute"),  # of its tip
        (("X_Pos", "Y_Pos", "Z_Pos", "q1", "q2", "q3"), "prismatic"),
        (("X_Pos", "Y_Pos"), "prismatic"),
        (("X_Pos", "Y_Pos", "V_Pos"), "prismatic"),
        (("tcp_x", "tcp_y", "tcp_z"), "prismatic"),
        (("X", "Y", "Z", "A", "B", "C"), "prismatic"),
    ],
)
def test_letters_that_are_no_joints_are_left(names, kind, tmp_path):
    assert lettered({name: meaning(name) for name in names}, robot(tmp_path, kind)) == ({}, set())


def test_letters_that_are_the_joints_names_are_no_guess(tmp_path):
    said = {name: meaning(name) for name in ("X_Pos", "Y_Pos", "C_Pos", "X_Strom", "Y_Strom", "C_Strom")}
    found, guessed = lettered(said, robot(tmp_path, names=("Y", "X", "C")))
    assert {name: m.joint for name, m in found.items()} == {
        "Y_Pos": 1, "X_Pos": 2, "C_Pos": 3, "Y_Strom": 1, "X_Strom": 2, "C_Strom": 3
    }  # fmt: skip
    assert (found["X_Pos"].signal, found["C_Strom"].signal, guessed) == ("position", "current", set())


@pytest.mark.parametrize(("reach", "offered"), [(0.58, False), (5.8e-4, True)])
def test_no_slider_is_taken_to_go_half_a_kilometre(reach, offered, tmp_path):
    """Of 0.58 m nobody had made metres that were read as millimetres."""
    q = reach * np.sin(np.outer(TIME, (1, 2, 3)))
    mends = [change.mend for change in transformations(robot(tmp_path), q) if change.kind == "unit"]
    assert any("metres read as millimetres" in mend for mend in mends) == offered
