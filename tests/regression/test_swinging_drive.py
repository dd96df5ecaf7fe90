"""Links on springs, against closed forms and another integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexmodels.files.robot_file import load_robot
from pyident.conditioning.motion import Motion
from pyident.regression.loads.swinging_drive import Spring, as_values, from_values, swung, up_to

MASS, STEP = 80.0, 0.004


def slider(q, dq, ddq, time):
    """The shipped axis with all its mass behind the belt; as its torques are held, no noise is taken away."""
    robot = load_robot("emps").with_parameters({"link1.m": MASS})
    held = np.zeros((len(time), 1))
    return robot, Motion(*(x[:, None] for x in (q, dq, ddq)), tau=held, time=time, tau_before=held)


@pytest.mark.parametrize("rotor", [0.0, 30.0])
@pytest.mark.parametrize("frequency", [0.5, 4.0, 9.0])
def test_one_sine_is_answered_as_by_a_belt(frequency, rotor):
    """Of the mass that follows the motor, a part may be the motor's own, which no belt moves."""
    behind = MASS - rotor
    spring = Spring(1 / (behind * (2 * np.pi * 6.0) ** 2), 0.1, rotor)
    time, w = np.arange(0, 12, STEP), 2 * np.pi * frequency
    q = 0.01 * np.sin(w * time)
    robot, motion = slider(q, 0.01 * w * np.cos(w * time), -(w**2) * q, time)
    changed = swung(robot, motion, {1: spring})[0]
    K = 1 / spring.compliance
    D = 2 * spring.damping * np.sqrt(behind * K)
    lag = -behind * w**2 * 0.01 / (K + 1j * w * D - behind * w**2)
    expected = np.imag(behind * w**2 * lag * np.exp(1j * w * time))
    late = time > 6  # the start has died down
    error = np.abs(changed - expected)[late].max() / np.abs(expected).max()
    assert error < 0.01


@pytest.mark.parametrize("swing", [6.0, 100.0])
def test_a_start_is_answered_as_an_integrator_says(swing):
    spring = Spring(1 / (MASS * (2 * np.pi * swing) ** 2), 0.05)
    time = np.arange(0, 3, STEP)
    pulse = np.exp(-(((time - 1) / 0.12) ** 2))
    robot, motion = slider(0 * time, 0 * time, pulse, time)
    changed = swung(robot, motion, {1: spring})[0]
    K = 1 / spring.compliance
    D = 2 * spring.damping * np.sqrt(MASS * K)

    def rate(t, x):
        force = MASS * np.exp(-(((t - 1) / 0.12) ** 2))
        return [x[1], (force - D * x[1] - K * x[0]) / MASS]

    found = solve_ivp(rate, (0, 3), [0, 0], t_eval=time, rtol=1e-10, atol=1e-14)
    expected = -MASS * np.array([rate(t, x)[1] for t, x in zip(time, found.y.T, strict=True)])
    limit = 0.01 if swing < 10 else 0.1  # beyond half of the rate a straight line follows what is slow alone
    np.testing.assert_allclose(changed, expected, atol=limit * np.abs(expected).max())


def test_springs_are_told_by_values_each_behind_those_before():
    springs = {3: Spring(1e-4, 0.1), 1: Spring(2e-4, np.inf), 2: Spring(3e-4, 0.05, 0.2)}
    assert from_values(as_values(springs)) == springs
    assert list(up_to(springs, 2)) == [3, 2]
    assert list(up_to(springs, 1)) == [1]
    assert up_to(springs, 4) == {}
