"""Signs of measured speeds are means over their error."""

from dataclasses import replace

import numpy as np
import pytest
import sympy

from flexmodels.effects import signals
from flexmodels.files.robot_file import load_robot
from pyident.conditioning.motion import Motion
from pyident.regression.regressor import regressor
from pyident.regression.rounded_signs import blurred

ZONE = 0.02  # [rad/s]


def _mean(law, at):
    """By quadrature over the error."""
    speeds = at + np.linspace(-ZONE, ZONE, 200_001)
    return float(np.mean(sympy.lambdify(signals.de, law, "numpy")(speeds)))


@pytest.mark.parametrize("law", [sympy.sign(signals.de), sympy.tanh(signals.de / 0.01)])
@pytest.mark.parametrize("speed", [-3.0, -0.019, 0.0, 0.004, 0.015, 0.025])
def test_law_is_the_mean_over_the_error(law, speed):
    found = sympy.lambdify(signals.de, blurred(law, ZONE), "numpy")(speed)
    assert found == pytest.approx(_mean(law, speed), abs=2e-5)


def test_without_a_dead_zone_and_without_speeds_the_law_stays():
    friction, ripple = sympy.sign(signals.de), sympy.sign(signals.tau)
    assert blurred(friction, 0.0) is friction
    assert blurred(ripple, ZONE) == ripple


def test_columns_of_a_robot_with_a_dead_zone():
    robot = load_robot("tx40")
    speeds = np.zeros((3, 6))
    speeds[:, 4], speeds[:, 5] = (0.5, 0.01, 0.015), (-2.0, 0.0, 0.015)
    still = np.zeros((3, 6))
    motion = Motion(still, speeds, still, still, np.arange(3.0))
    Phi = regressor(robot, motion)
    at = Phi.columns.index
    own = Phi.matrix[:, 4, at("joint5.coulomb")]
    shared = Phi.matrix[:, 4, at("joint5.joint_coupling.coulomb")]
    assert own == pytest.approx([1, 0.5, 0.75])
    assert shared == pytest.approx([-1, 0.5, 1], abs=0.05)  # of the sum; the law itself rounds a little
    assert Phi.matrix[:, 4, at("joint5.viscous")] == pytest.approx(speeds[:, 4])
    sharp = robot.with_settings(processing=replace(robot.settings.processing, dead_zone=0.0))
    assert regressor(sharp, motion).matrix[:, 4, at("joint5.coulomb")] == pytest.approx([1, 1, 1])
