"""Pivots of the mass matrix: Pinocchio's determinant, and eigenvalues where no body is like that."""

import casadi as ca
import numpy as np
import pytest
from pinocchio_model import PinocchioRobot, mixed_robot, random_motion, tree_robot

from flexmodels.mechanics import articulated, dynamics, projected

ROBOTS = [mixed_robot(), tree_robot(seed=1), tree_robot(seed=0, passive=2)]
ARMATURE = 0.3  # of every motor [kg m2 or kg]


def functions(robot):
    """(q, bodies) -> pivots and mass matrix, and the armature (n,)."""
    m = dynamics.mechanism(robot)
    n, joints = m.q.numel(), len(robot.joints)
    armature = np.r_[np.full(joints, ARMATURE), np.zeros(n - joints)]
    if robot.passive:
        pivots = projected.pivots(m, ca.diag(ca.SX(armature)))
    else:
        pivots = articulated.pivots(m, ca.SX(armature))
    a = ca.SX.sym("a", n)
    M = ca.jacobian(dynamics.inverse_dynamics(m, a), a) + np.diag(armature)
    both = ca.Function("f", [m.q, m.v, a, m.bodies], [pivots, M])
    zero = np.zeros(n)
    return lambda q, bodies: tuple(np.array(v) for v in both(q, zero, zero, bodies)), armature


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_their_product_is_the_determinant(robot):
    both, armature = functions(robot)
    bodies = np.array([list(link.values.values()) for link in robot.links]).T
    oracle = PinocchioRobot(robot)
    for q in random_motion(robot, 5)[0]:
        pivots, _ = both(q, bodies)
        assert (pivots > 0).all()
        expected = np.linalg.slogdet(oracle.mass_matrix(q) + np.diag(armature))[1]
        assert np.log(pivots).sum() == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_as_many_are_negative_as_eigenvalues(robot):
    """Sylvester's law of inertia, for numbers that no body has."""
    both, _ = functions(robot)
    sound = np.array([list(link.values.values()) for link in robot.links]).T
    rng = np.random.default_rng(2)
    counts = set()
    for q in random_motion(robot, 20)[0]:
        pivots, M = both(q, sound * rng.normal(0.5, 1, sound.shape))
        negative = int((np.linalg.eigvalsh(M) < 0).sum())
        assert int((pivots < 0).sum()) == negative
        counts.add(negative)
    assert len(counts) > 1
