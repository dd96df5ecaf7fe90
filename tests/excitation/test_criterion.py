"""What a motion tells: the information matrix of one joint in closed form, and independent columns."""

from dataclasses import replace

import numpy as np
import pytest
from one_joint import one_joint

from pyident.excitation.criterion import Yardstick, along, independent, information
from pyident.excitation.fourier import Reference
from pyident.excitation.separation.rivals import remaining
from pyident.regression.spectrum import Floor

SIGMA, PERIOD, DURATION = 0.7, 0.02, 20.0


def cosine() -> Reference:
    """Whole periods at 0.5 Hz: every spectrum is one line, and the band holds it all."""
    time = np.arange(round(DURATION / PERIOD)) * PERIOD
    w = np.pi
    q = 0.4 * np.cos(w * time)[:, None]
    dq = -0.4 * w * np.sin(w * time)[:, None]
    return Reference(time, q, dq, -(w**2) * q)


def level(period: float) -> Yardstick:
    """White noise of SIGMA on every sample."""
    return Yardstick(Floor(np.array([0.0, 20.0]), np.array([[SIGMA, SIGMA]])), period, 1000)


def smooth_joint():
    """One joint without dry friction, so that no sample is left out."""
    robot = one_joint()
    (joint,) = robot.joints
    laws = {name: values for name, values in joint.values.items() if name != "coulomb"}
    return replace(robot, joints=(replace(joint, values=laws),))


def test_the_information_of_one_joint_is_that_of_its_closed_form():
    robot, motion = smooth_joint(), cosine()
    found = along(robot, level(PERIOD), motion)
    names = list(robot.linear_parameters)
    inertia, viscous = names.index("joint1.J_m"), names.index("joint1.viscous")
    gram = found.gram / SIGMA**-2
    assert gram[inertia, inertia] == pytest.approx(np.sum(motion.ddq**2), rel=1e-6)
    assert gram[viscous, viscous] == pytest.approx(np.sum(motion.dq**2), rel=1e-6)
    assert abs(gram[inertia, viscous]) < 1e-6 * np.sqrt(gram[inertia, inertia] * gram[viscous, viscous])


def test_samples_that_are_taken_four_times_as_often_say_four_times_as_much():
    fine = along(smooth_joint(), level(PERIOD / 4), cosine()).gram
    coarse = along(smooth_joint(), level(PERIOD), cosine()).gram
    assert fine == pytest.approx(4 * coarse)


def test_of_two_columns_that_are_one_only_one_is_independent():
    robot = smooth_joint()
    gram = along(robot, level(PERIOD), cosine()).gram
    base = independent(gram)
    names = np.array(list(robot.linear_parameters))[base]
    assert len(base) == 2  # the motor's inertia and the link's are the same; and the viscous friction
    assert "joint1.viscous" in names
    sizes = np.diag(gram)[base]
    assert information(gram, base) == pytest.approx(np.log(sizes).sum() / 2)


def test_a_column_that_is_zero_but_for_rounding_is_not_independent():
    rng = np.random.default_rng(0)
    A = rng.standard_normal((60, 3))
    A[:, 1] *= 1e-16
    assert independent(A.T @ A).tolist() == [0, 2]


def test_what_remains_is_what_least_squares_leaves():
    rng = np.random.default_rng(0)
    A, y = rng.standard_normal((50, 6)) * 10.0 ** np.arange(-3, 3), rng.standard_normal(50)
    A[:, 5] = A[:, 4] * 3 + A[:, 0]  # no full rank
    expected = np.sum((y - A @ np.linalg.lstsq(A, y, rcond=1e-12)[0]) ** 2)
    assert remaining(A, y) == pytest.approx(expected)
