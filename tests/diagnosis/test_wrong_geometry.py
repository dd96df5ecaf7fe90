"""A link 2 mm longer than the robot file says, in another library's torques, is named and measured."""

from dataclasses import replace

import pytest
from six_axis_logs import arm, made

from pyident.diagnosis.diagnose import concluded, searched
from pyident.rules.rules import RULES

LONGER = 0.002


def never(_):
    raise AssertionError("nothing is simulated where the loop is unknown")


@pytest.fixture(scope="module")
def found():
    robot = arm()
    x, y, z = robot.joints[2].origin
    longer = replace(robot.joints[2], origin=(x, y, z + LONGER))
    true = replace(robot, joints=(*robot.joints[:2], longer, *robot.joints[3:]))
    logs = [made(true, seed, duration=14.0) for seed in range(3)]
    return concluded(searched(robot, logs[:2], never, rules=RULES), never, logs[2:])


def test_the_length_is_named(found):
    assert found.verdict in ("missing_effect", "cannot_tell"), found.sentence
    assert found.sentence.startswith("Wrong in the robot file")
    assert ("origin[z]", "joint3") in {(n.effect, n.joint) for n in found.findings[0].tie}


def test_its_error_is_measured(found):
    (named,) = [n for n in found.findings[0].tie if (n.effect, n.joint) == ("origin[z]", "joint3")]
    assert named.values["correction"] == pytest.approx(LONGER, rel=0.2)
    assert named.units["correction"] == "m"
