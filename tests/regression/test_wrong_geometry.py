"""A link that is longer than the robot file says, in another library's torques, is measured."""

from dataclasses import replace

import numpy as np
import pytest
from six_axis_logs import arm, made, plain

from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate, columns
from pyident.diagnosis.base.projection import gain, solve_base
from pyident.diagnosis.base.setting import set_up
from pyident.regression.spectrum import equations

PACE = 6.0  # a slow arm feels gravity alone, and that a link's mass explains as well


def logs(longer: float):
    """longer: by which joint 3 is farther from joint 2 [m]."""
    robot = arm()
    x, y, z = robot.joints[2].origin
    joint = replace(robot.joints[2], origin=(x + longer, y, z))
    true = replace(robot, joints=(*robot.joints[:2], joint, *robot.joints[3:]))
    return [made(true, seed, plain, 20.0, PACE) for seed in range(3)]


def test_two_millimetres_are_measured():
    robot, given = arm(), logs(0.002)[:2]
    setting = set_up(robot, given)
    plain_data = equations(robot, [condition(log, robot) for log in given], [log.period for log in given])
    level = 1 / setting.solution.weights
    levels = [np.repeat(level[:, None], e.y.shape[1], axis=1) for e in plain_data]
    data = [e.over(of) for e, of in zip(plain_data, levels, strict=True)]
    found = gain(solve_base(data), columns(setting.robot, Candidate("origin[x]", 3), data, levels))
    assert found.std[0] < 3e-4
    assert found.coefficients[0] == pytest.approx(0.002, abs=3 * found.std[0])
