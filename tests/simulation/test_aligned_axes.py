"""The controller that stands in for an unknown one, on an arm whose axes align."""

from dataclasses import replace

import numpy as np
from scipy.linalg import eigvalsh

from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot
from pyident.simulation.replica import _mass_matrix, _stand_in


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
    M = _mass_matrix(robot, q)
    gains = _stand_in(robot, q, 0.001)
    omega = 2 * np.pi * 10.0
    found = eigvalsh(np.diag(gains.Kp), M) / omega**2
    assert np.isclose(found.sum(), 3.0)
    by_diagonal = eigvalsh(np.diag(np.diag(M)), M)
    assert by_diagonal.max() > 3.0
