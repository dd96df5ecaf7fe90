"""Which columns every log of a motion shares, and which hold a log's own noise."""

import pytest

from flexmodels.files.robot_file import load_robot
from pyident.diagnosis.base.candidates import Candidate, is_smooth, law_of, units_of


@pytest.mark.parametrize(
    ("effect", "smooth"),
    [
        ("stribeck", True),
        ("gravity_spring", True),
        ("origin[z]", True),
        ("torque_delay", False),
        ("hardening_stiffness", False),
        ("joint_coupling", False),
        ("payload", False),
    ],
)
def test_columns_of_noisy_signals_are_a_replicas_own(effect, smooth):
    assert is_smooth(load_robot("four_link"), Candidate(effect, 2)) is smooth


def test_a_description_is_a_law_with_one_parameter():
    robot = load_robot("four_link")
    law = law_of(robot, Candidate("axis[y]", 2))
    assert [(p.name, p.unit) for p in law.linear] == [("correction", "rad")]
    assert not law.nonlinear
    assert units_of(robot, Candidate("stribeck", 2))["velocity"] == "rad/s"
