"""What the words of a name and its unit say."""

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint

from pyident.inspection.inspect_log import inspect_log
from pyident.inspection.words import meaning


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
