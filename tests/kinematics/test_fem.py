"""The finite elements of open chains: hinge formulas, transfer functions, against Pinocchio."""

import casadi as ca
import numpy as np
import pytest
from pinocchio_model import PinocchioRobot, mixed_robot, random_motion

from flexmodels.files.robot_file import load_robot
from flexmodels.mechanics import dynamics
from flexmodels.robot import Robot
from pyident.kinematics import chain
from pyident.kinematics.elements import hinge
from pyident.kinematics.elements.nodes import Nodes
from pyident.kinematics.elements.triads import compose
from pyident.kinematics.robot_structure import of_robot
from pyident.kinematics.transfer import tip_positions

ROBOTS = [load_robot("four_link"), load_robot("emps"), mixed_robot(0), mixed_robot(1)]
robots = pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)


def hinge_states(samples: int = 50) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    e = rng.uniform(-0.5, 0.5, size=(3, samples))
    e[0] = rng.uniform(-3, 3, size=samples)
    return e, rng.normal(size=(3, samples))


def skew_part(W: np.ndarray) -> np.ndarray:
    """ω of dR Rᵀ (3, 3, N)."""
    return np.stack([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]) / 2


def test_hinge_deformations_invert_the_relative_rotation():
    e, _ = hinge_states()
    n_p = np.linalg.qr(np.random.default_rng(4).normal(size=(50, 3, 3)))[0].transpose(1, 2, 0)
    n_q = compose(n_p, hinge.relative_rotation(e))
    np.testing.assert_allclose(hinge.deformations(n_p, n_q), e, atol=1e-14)


def test_hinge_axes_are_the_angular_velocity():
    (e, de), h = hinge_states(), 1e-6
    change = hinge.relative_rotation(e + h * de) - hinge.relative_rotation(e - h * de)
    R = hinge.relative_rotation(e)
    w = skew_part(compose(change / (2 * h), R.swapaxes(0, 1)))
    np.testing.assert_allclose(np.einsum("ijn,jn->in", hinge.rate_axes(e), de), w, atol=1e-9)


def test_hinge_convective_rate_is_the_derivative_of_the_axes():
    (e, de), h = hinge_states(), 1e-6
    change = (hinge.rate_axes(e + h * de) - hinge.rate_axes(e - h * de)) / (2 * h)
    np.testing.assert_allclose(hinge.convective_rate(e, de), np.einsum("ijn,jn->in", change, de), atol=1e-8)


def test_a_hinge_bent_too_far_is_refused():
    with pytest.raises(ValueError, match="check that eps is in rad"):
        hinge.relative_rotation(np.array([[0.0], [0.9], [0.9]]))


def link_nodes(robot: Robot, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> Nodes:
    return chain.nodes(of_robot(robot), q.T, dq.T, ddq.T)


@robots
def test_chain_against_pinocchio(robot: Robot):
    samples = 20
    q, dq, ddq = random_motion(robot, samples)
    nodes, oracle = link_nodes(robot, q, dq, ddq), PinocchioRobot(robot)
    expected = [oracle.nodes(q[i], dq[i], ddq[i]) for i in range(samples)]
    for k, (x, R) in enumerate(of_robot(robot).bodies):
        position, orientation = nodes.positions[x], nodes.orientations[R]
        ours = {
            "x": position.x,
            "R": orientation.R,
            "v": position.v,
            "w": orientation.w,
            "a": position.a,
            "dw": orientation.dw,
            "DF": np.concatenate([position.DF, orientation.DF]),
        }
        for name, value in ours.items():
            want = np.stack([getattr(motion[k], name) for motion in expected], axis=-1)
            scale = max(1.0, np.abs(want).max())
            np.testing.assert_allclose(
                value, want, rtol=0, atol=1e-12 * scale, err_msg=f"link {k + 1}: {name}"
            )


@robots
def test_DF_and_D2F_against_finite_differences(robot: Robot):
    q, dq, ddq = random_motion(robot, 10)
    h = 1e-6
    nodes = link_nodes(robot, q, dq, 0 * ddq)
    before, after = (link_nodes(robot, q + s * h * dq, dq, 0 * ddq) for s in (-1, 1))
    for x, position in nodes.positions.items():
        v = (after.positions[x].x - before.positions[x].x) / (2 * h)
        a = (after.positions[x].v - before.positions[x].v) / (2 * h)
        np.testing.assert_allclose(position.v, v, atol=1e-6)
        np.testing.assert_allclose(np.einsum("ijn,nj->in", position.DF, dq), v, atol=1e-6)
        np.testing.assert_allclose(position.a, a, rtol=1e-6, atol=1e-6)
    for R, orientation in nodes.orientations.items():
        dR = (after.orientations[R].R - before.orientations[R].R) / (2 * h)
        w = skew_part(compose(dR, orientation.R.swapaxes(0, 1)))
        dw = (after.orientations[R].w - before.orientations[R].w) / (2 * h)
        np.testing.assert_allclose(np.einsum("ijn,nj->in", orientation.DF, dq), w, atol=1e-6)
        np.testing.assert_allclose(orientation.dw, dw, rtol=1e-6, atol=1e-6)


@robots
def test_tip_against_the_plant(robot: Robot):
    m = dynamics.mechanism(robot)
    plant = ca.Function("tip", [m.q], [dynamics.tip_position(m)])
    q, _, _ = random_motion(robot, 10)
    np.testing.assert_allclose(tip_positions(robot, q), np.array(plant(q.T)).T, atol=1e-13)
