"""Φ p is the generalised force of eq. (8): against Pinocchio and against the plant's Newton-Euler."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
import sympy
from pinocchio_model import PinocchioRobot, mixed_robot, random_motion, tree_robot

from flexmodels.effects import signals
from flexmodels.effects.effect import Effect, Parameter
from flexmodels.files.robot_file import load_robot
from flexmodels.link import LINK_PARAMETERS
from flexmodels.mechanics import dynamics
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.regressor import Regressor, regressor, regressor_blocks

ROBOTS = [
    *(load_robot(name) for name in ("four_link", "emps", "parallelogram")),
    *(mixed_robot(0), mixed_robot(1), tree_robot(0)),
]
robots = pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)


def motion_of(robot: Robot, samples: int = 30) -> Motion:
    return Motion(*random_motion(robot, samples))


def force(Phi: Regressor, values: dict[str, float]) -> np.ndarray:
    return Phi.matrix @ np.array([values[name] for name in Phi.columns])


def joint_forces(robot: Robot, motion: Motion) -> np.ndarray:
    """Motor inertia, friction, stiffness and damping, written out once more: N x n."""
    total = np.zeros_like(motion.q)
    for k, joint in robot.numbered:
        value = {name: v for law in joint.values.values() for name, v in law.items()}
        at = robot.coordinates.index(f"joint{k}.e")
        de = motion.dq[:, at]
        total[:, at] = (
            value["J_m"] * motion.ddq[:, at] + value["coulomb"] * np.sign(de) + value["viscous"] * de
        )
        total[:, at] += value.get("offset", 0.0)
        for i in joint.deformations:
            at = robot.coordinates.index(f"joint{k}.eps[{i}]")
            total[:, at] = value[f"k[{i}]"] * motion.q[:, at] + value[f"d[{i}]"] * motion.dq[:, at]
    return total


@robots
def test_Phi_p_against_pinocchio(robot: Robot):
    motion, oracle = motion_of(robot), PinocchioRobot(robot)
    links = np.stack(
        [oracle.inverse_dynamics(*state) for state in zip(motion.q, motion.dq, motion.ddq, strict=True)]
    )
    want = links + joint_forces(robot, motion)
    ours = force(regressor(robot, motion), robot.parameters)
    np.testing.assert_allclose(ours, want, rtol=0, atol=1e-12 * np.abs(want).max())


@robots
def test_Phi_p_M_and_h_against_the_plant(robot: Robot):
    m = dynamics.mechanism(robot)
    a = ca.SX.sym("a", m.q.numel())
    plant = ca.Function("plant", [m.q, m.v, a, m.bodies], [dynamics.inverse_dynamics(m, a)])
    bodies = np.array([list(link.values.values()) for link in robot.links]).T
    motion, oracle = motion_of(robot), PinocchioRobot(robot)
    force_of_links = [
        np.array(plant(*s, bodies))[:, 0] for s in zip(motion.q, motion.dq, motion.ddq, strict=True)
    ]
    want = np.stack(force_of_links) + joint_forces(robot, motion)
    ours = force(regressor(robot, motion), robot.parameters)
    np.testing.assert_allclose(ours, want, rtol=0, atol=1e-12 * np.abs(want).max())

    q, dq, still = motion.q[0], motion.dq[0], np.zeros_like(motion.q[0])
    h = np.array(plant(q, dq, still, bodies))[:, 0]
    M = np.column_stack([np.array(plant(q, dq, unit, bodies))[:, 0] - h for unit in np.eye(len(q))])
    np.testing.assert_allclose(h, oracle.inverse_dynamics(q, dq, still), atol=1e-11 * np.abs(h).max())
    np.testing.assert_allclose(M, oracle.mass_matrix(q), atol=1e-11 * np.abs(M).max())


@robots
def test_Phi_is_linear_in_any_parameters(robot: Robot):
    rng = np.random.default_rng(5)
    values = {name: rng.uniform(1, 2) for name in robot.parameters}
    values |= {
        name: 30.0 for name in values if name.endswith(("J[xx]", "J[yy]", "J[zz]"))
    }  # Pinocchio insists
    motion, other = motion_of(robot), robot.with_parameters(values)
    oracle = PinocchioRobot(other)
    links = np.stack(
        [oracle.inverse_dynamics(*state) for state in zip(motion.q, motion.dq, motion.ddq, strict=True)]
    )
    want = links + joint_forces(other, motion)
    ours = force(regressor(robot, motion), values)
    np.testing.assert_allclose(ours, want, rtol=0, atol=1e-12 * np.abs(want).max())


def test_names_of_the_paper_robot():
    robot = load_robot("four_link")
    Phi = regressor(robot, motion_of(robot, 3))
    assert Phi.matrix.shape == (3, 16, 76)
    assert Phi.columns == tuple(robot.parameters)
    assert Phi.rows == robot.coordinates


def test_blocks_make_the_whole():
    robot = mixed_robot()
    motion = motion_of(robot, 1111)
    whole = regressor(robot, motion).matrix
    for part, Phi in regressor_blocks(robot, motion, block=500):
        np.testing.assert_array_equal(Phi, whole[part])


def test_no_dry_friction_at_rest():
    robot = load_robot("emps")
    rest = np.zeros((1, 1))
    Phi = regressor(robot, Motion(rest, rest, rest))
    assert Phi.matrix[0, 0, Phi.columns.index("joint1.coulomb")] == 0.0


def with_law(robot: Robot, effect: Effect, k: int) -> Robot:
    joints = list(robot.joints)
    values = {**joints[k - 1].values, effect.name: {p.name: 0.0 for p in effect.parameters}}
    joints[k - 1] = replace(joints[k - 1], values=values, own={effect.name: effect})
    return replace(robot, joints=tuple(joints))


def law(name: str, expression: sympy.Expr, *parameters: Parameter, on: sympy.Symbol = signals.e) -> Effect:
    return Effect(name=name, title=name, forces={on: expression}, parameters=parameters, citation="test")


def test_a_new_law_gets_its_column():
    c = Parameter("c", "N.m")
    expression = c.symbol * sympy.cos(signals.eps[1]) * signals.tau * signals.beyond.de
    robot = with_law(load_robot("four_link"), law("odd", expression, c, on=signals.eps[3]), 2)
    tau = np.random.default_rng(1).normal(size=(30, 4))
    motion = replace(motion_of(robot), tau=tau)
    Phi = regressor(robot, motion)
    at = {name: j for j, name in enumerate(robot.coordinates)}
    want = np.cos(motion.q[:, at["joint2.eps[1]"]]) * tau[:, 1] * motion.dq[:, at["joint3.e"]]
    column = Phi.matrix[:, :, Phi.columns.index("joint2.odd.c")]
    np.testing.assert_allclose(column[:, at["joint2.eps[3]"]], want, atol=1e-15)
    assert np.count_nonzero(column.any(axis=0)) == 1


def test_a_law_that_is_not_linear_is_refused():
    c, speed = Parameter("c", "N.m"), Parameter("speed", "rad/s")
    decay = law("decay", c.symbol * sympy.exp(-signals.de * speed.symbol), c, speed)
    robot = with_law(load_robot("four_link"), decay, 3)
    with pytest.raises(ValueError, match=r"effect decay is not linear in its parameter speed.*need a grid"):
        regressor(robot, motion_of(robot))


def test_a_product_of_parameters_is_refused():
    a, b = Parameter("a", "N.m"), Parameter("b", "1")
    robot = with_law(load_robot("four_link"), law("product", a.symbol * b.symbol * signals.e, a, b), 1)
    with pytest.raises(ValueError, match="effect product is not linear in its parameter a"):
        regressor(robot, motion_of(robot))


def test_a_signal_that_was_not_logged_is_named():
    c = Parameter("c", "1")
    robot = with_law(load_robot("four_link"), law("thirsty", c.symbol * signals.tau, c), 4)
    with pytest.raises(ValueError, match=r"effect thirsty at joint 4 needs the signal joint4\.tau"):
        regressor_blocks(robot, motion_of(robot))


def test_a_motion_of_the_wrong_size_is_refused():
    robot = load_robot("four_link")
    motion = motion_of(robot)
    with pytest.raises(ValueError, match=r"motion\.dq .* has shape \(30, 15\), not \(30, 16\)"):
        regressor(robot, replace(motion, dq=motion.dq[:, :15]))


def test_a_motion_that_is_not_finite_is_refused():
    robot = load_robot("emps")
    motion = motion_of(robot)
    motion.ddq[7] = np.nan
    with pytest.raises(ValueError, match=r"motion\.ddq of robot emps is not finite at sample 7"):
        regressor(robot, motion)


def test_columns_count_links_first():
    robot = load_robot("four_link")
    columns = regressor(robot, motion_of(robot, 2)).columns
    assert columns[: len(LINK_PARAMETERS)] == tuple(f"link1.{name}" for name in LINK_PARAMETERS)
