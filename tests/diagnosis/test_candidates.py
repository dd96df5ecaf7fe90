"""What a diagnosis may name: laws, and errors of the description."""

from flexmodels.files.robot_file import load_robot
from pyident.diagnosis.base.candidates import Candidate, law_of, units_of


def test_a_description_is_a_law_with_one_parameter():
    robot = load_robot("four_link")
    law = law_of(robot, Candidate("axis[y]", 2))
    assert [(p.name, p.unit) for p in law.linear] == [("correction", "rad")]
    assert not law.nonlinear
    assert units_of(robot, Candidate("stribeck", 2))["velocity"] == "rad/s"
