"""Branched robots, hinges that only twist and hinges that follow: against Pinocchio."""

import casadi as ca
import numpy as np
import pytest
from pinocchio_model import PinocchioRobot, random_motion, tree_robot

from flexmodels.effects import CATALOGUE
from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.mechanics import articulated, dynamics, projected
from flexmodels.robot import Robot, RobotError
from pyident.kinematics import chain
from pyident.kinematics.robot_structure import of_robot
from pyident.kinematics.transfer import tip_positions

TREES = [tree_robot(0), tree_robot(1)]
FOLLOWING = [tree_robot(0, passive=1), tree_robot(1, passive=3)]  # no pins: the plant and Pinocchio only
ARMATURE = 2.0  # of every motor [kg m2 or kg]


def bodies(robot: Robot) -> np.ndarray:
    return np.array([list(link.values.values()) for link in robot.links]).T


def accelerations(robot: Robot, free: np.ndarray):
    """(q, v, force) -> acceleration, imbalance of the plant's forward dynamics, and the armature (n,)."""
    m = dynamics.mechanism(robot)
    force = ca.SX.sym("force", m.q.numel())
    armature = np.r_[np.full(len(robot.joints), ARMATURE), np.zeros(len(free) - len(robot.joints))]
    if robot.passive:
        out = projected.forward_dynamics(m, force, ca.diag(ca.SX(armature)), ca.SX(free))
    else:
        out = articulated.forward_dynamics(m, force, ca.SX(armature), ca.SX(free))
    function = ca.Function("a", [m.q, m.v, force, m.bodies], list(out))
    return lambda *state: (np.array(v)[:, 0] for v in function(*state, bodies(robot))), armature


@pytest.mark.parametrize("robot", TREES + FOLLOWING, ids=lambda robot: robot.name)
def test_plant_against_pinocchio(robot: Robot):
    oracle, m = PinocchioRobot(robot), dynamics.mechanism(robot)
    a = ca.SX.sym("a", m.q.numel())
    inverse = ca.Function("f", [m.q, m.v, a, m.bodies], [dynamics.inverse_dynamics(m, a)])
    tip = ca.Function("tip", [m.q], [dynamics.tip_position(m)])
    free = np.ones(m.q.numel())
    free[[1, 3]] = 0.0
    forward, armature = accelerations(robot, free)
    rng = np.random.default_rng(4)
    for q, dq, ddq in zip(*random_motion(robot, 10), strict=True):
        want = oracle.inverse_dynamics(q, dq, ddq)
        np.testing.assert_allclose(
            np.array(inverse(q, dq, ddq, bodies(robot)))[:, 0], want, atol=1e-11 * np.abs(want).max()
        )
        node = oracle.nodes(q, dq, ddq)[robot.tip_link - 1]  # pyright: ignore
        np.testing.assert_allclose(np.array(tip(q))[:, 0], node.x + node.R @ robot.tip, atol=1e-13)
        push, moves = rng.normal(size=len(q)), free == 1
        M = oracle.mass_matrix(q) + np.diag(armature)
        net = push - oracle.inverse_dynamics(q, dq, 0 * q)
        expected = np.zeros(len(q))
        expected[moves] = np.linalg.solve(M[np.ix_(moves, moves)], net[moves])
        found, imbalance = forward(q, dq, push)
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())
        held = (net - M @ expected)[~moves]
        np.testing.assert_allclose(imbalance[~moves], held, atol=1e-9 * np.abs(net).max())


@pytest.mark.parametrize("robot", TREES, ids=lambda robot: robot.name)
def test_finite_elements_against_pinocchio(robot: Robot):
    structure, oracle = of_robot(robot), PinocchioRobot(robot)
    assert structure.is_chain
    q, dq, ddq = random_motion(robot, 10)
    nodes = chain.nodes(structure, q.T, dq.T, ddq.T)
    expected = [oracle.nodes(*state) for state in zip(q, dq, ddq, strict=True)]
    for k, (x, R) in enumerate(structure.bodies):
        p, o = nodes.positions[x], nodes.orientations[R]
        for i, motions in enumerate(expected):
            want = motions[k]
            np.testing.assert_allclose(p.x[:, i], want.x, atol=1e-12)
            np.testing.assert_allclose(p.a[:, i], want.a, atol=1e-9)
            np.testing.assert_allclose(o.R[..., i], want.R, atol=1e-12)
            np.testing.assert_allclose(o.dw[:, i], want.dw, atol=1e-9)
            np.testing.assert_allclose(np.vstack([p.DF[..., i], o.DF[..., i]]), want.DF, atol=1e-12)


def test_both_recursions_of_the_plant_agree():
    """Articulated bodies and the projected mass matrix, on a tree that either can do."""
    robot = TREES[0]
    m = dynamics.mechanism(robot)
    force, free = ca.SX.sym("force", m.q.numel()), np.ones(m.q.numel())
    free[0] = 0
    (q,), (dq,), (push,) = random_motion(robot, 1)
    found = []
    armature = ca.SX(np.full(len(free), 0.1))
    for method, inertia in (
        (articulated.forward_dynamics, armature),
        (projected.forward_dynamics, ca.diag(armature)),
    ):
        a, imbalance = method(m, force, inertia, ca.SX(free))
        function = ca.Function("a", [m.q, m.v, force, m.bodies], [a, imbalance[0]])
        found.append(np.vstack([np.array(v) for v in function(q, dq, push, bodies(robot))]))
    np.testing.assert_allclose(found[0], found[1], atol=1e-9 * np.abs(found[1]).max())


def test_the_tip_belongs_to_its_link():
    robot = TREES[0]
    q = random_motion(robot, 5)[0]
    m = dynamics.mechanism(robot)
    tip = ca.Function("tip", [m.q], [dynamics.tip_position(m)])
    np.testing.assert_allclose(tip_positions(robot, q), np.array(tip(q.T)).T, atol=1e-13)


def test_a_hinge_that_only_twists_has_one_stiffness():
    robot = TREES[0]
    names = [name for name in robot.parameters if name.startswith("joint1.")]
    assert {"joint1.k[1]", "joint1.d[1]"} <= set(names)
    assert not {"joint1.k[2]", "joint1.d[3]"} & set(names)
    assert [c for c in robot.coordinates if c.startswith("joint1.")] == ["joint1.e", "joint1.eps[1]"]
    stiffness = robot.joints[0].law("stiffness")
    assert [p.name for p in stiffness.parameters] == ["k[1]"]
    assert robot.joints[2].law("stiffness") is CATALOGUE["stiffness"]
    with pytest.raises(RobotError, match="effect damping acts on deformations that joint 2"):
        robot.with_effect(2, "damping")


def test_a_tree_survives_writing_and_reading(tmp_path):
    robot = TREES[0].with_settings(identification=None, line=None)
    save_robot(robot, tmp_path / "tree.toml")
    assert load_robot(tmp_path / "tree.toml") == robot
