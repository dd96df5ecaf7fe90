"""Columns without names: a derivative is told by one ratio for all joints, which a torque has not."""

import numpy as np
import pytest

from pyident.inspection.inspect_log import inspect_log

TIME = np.arange(600) * 0.005
RATES = np.array([2.0, 3.1, 4.3])  # rad/s
ANGLES = np.sin(np.outer(TIME, RATES))
SPEEDS = RATES * np.cos(np.outer(TIME, RATES))
TORQUES = -(RATES**2) * ANGLES * [12.0, 7.0, 2.5]  # of bodies that nothing but their inertia holds


def signals(folder, *blocks):
    np.savetxt(folder / "raw.csv", np.column_stack([TIME, *blocks]), delimiter=",", fmt="%.7g")
    found = inspect_log([folder / "raw.csv"])
    return [c.signal for c in found.channels][1:], " ".join(found.questions)


@pytest.mark.parametrize("unit", [1.0, 180 / np.pi, 30 / np.pi])
def test_a_speed_in_another_unit_is_still_a_derivative(unit, tmp_path):
    found, _ = signals(tmp_path, ANGLES, unit * SPEEDS)
    assert found == ["position"] * 3 + ["velocity"] * 3


def test_speeds_and_torques_alone_are_asked(tmp_path):
    found, asked = signals(tmp_path, SPEEDS, TORQUES)
    assert found == ["unknown"] * 6
    assert "no column looks like the position of a joint: which are they?" in asked


def test_torques_behind_the_speeds_are_no_accelerations(tmp_path):
    found, _ = signals(tmp_path, ANGLES, SPEEDS, TORQUES)
    assert found == ["position"] * 3 + ["velocity"] * 3 + ["torque"] * 3
