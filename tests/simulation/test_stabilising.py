"""The controller that stands in for an unknown one: on an arm whose axes align, on one that stretches."""

from dataclasses import replace

import numpy as np
from scipy.linalg import eigvalsh

from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot
from pyident.simulation.stabilising import _mass_matrices, stabilising_controller


def wrist() -> Robot:
    """Three joints, of which the first and the last turn about one line; rotors weigh next to nothing."""
    laws = {"motor_inertia": {"J_m": 1e-4}}
    up = Joint("revolute", (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), False, laws)
    across = replace(up, x=(0.0, 1.0, 0.0), y=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.3))
    last = replace(up, origin=(0.0, 0.0, 0.3))
    links = tuple(
        Link(m, (0.0, 0.0, 0.1), (0.02 * m, 0.0, 0.0, 0.02 * m, 0.0, 0.01 * m)) for m in (0.1, 0.1, 3.0)
    )
    return Robot("wrist", (up, across, last), links, tip=(0.0, 0.0, 0.1))


def test_its_frequencies_add_up_to_those_of_its_joints():
    """Squared ones, over ω²; by the diagonal of the mass matrix the last joint would be far faster."""
    robot, q = wrist(), np.zeros((1, 3))
    (M,) = _mass_matrices(robot, q)
    gains = stabilising_controller(robot, q, 0.001)
    omega = 2 * np.pi * 10.0
    found = eigvalsh(np.diag(gains.Kp), M) / omega**2
    assert np.isclose(found.sum(), 3.0)
    by_diagonal = eigvalsh(np.diag(np.diag(M)), M)
    assert by_diagonal.max() > 3.0


def test_its_gains_hold_in_every_pose_of_a_motion():
    """A point on two links of 1 m leaves the first joint m sin² as inertia of its own, none when stretched.

    A damping that takes more than twice the speed within a sample makes it grow.
    """
    up = Joint("revolute", (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), False, {})
    links = (Link(0.0, (0.0, 0.0, 0.0), (0.01, 0.0, 0.0, 0.01, 0.0, 0.01)),) * 2
    point = replace(links[1], m=1.0, ms=(1.0, 0.0, 0.0), J=(0.0, 0.0, 0.0, 1.0, 0.0, 1.02))
    arm = Robot("two", (up, replace(up, origin=(1.0, 0.0, 0.0))), (links[0], point), tip=(1.0, 0.0, 0.0))
    bent = np.column_stack([np.zeros(50), np.linspace(1.6, 0.0, 50)])
    for period in (0.001, 0.004, 0.01):
        gains = stabilising_controller(arm, bent, period)
        rates = [eigvalsh(np.diag(gains.Kd), M).max() * period for M in _mass_matrices(arm, bent)]
        assert max(rates) < 2.0
        at_first = stabilising_controller(arm, bent[:1], period)
        assert max(eigvalsh(np.diag(at_first.Kd), M).max() for M in _mass_matrices(arm, bent)) * period > 2.0


def test_an_arm_of_which_nothing_is_known_gets_a_loop_without_gains():
    robot = wrist()
    empty = robot.with_parameters(dict.fromkeys(robot.linear_parameters, 0.0))
    gains = stabilising_controller(empty, np.zeros((3, 3)), 0.004)
    assert (gains.Kp, gains.Kd) == ((0.0,) * 3, (0.0,) * 3)
