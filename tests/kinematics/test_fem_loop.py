"""Closed loops: a parallelogram-driven arm, as on palletising robots, against its closed form."""

from dataclasses import fields, replace

import casadi as ca
import numpy as np
import pytest
from pinocchio_model import mixed_robot, random_motion

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.kinematics import assembly, chain, loop, transfer
from pyident.kinematics.elements.beam import Beam
from pyident.kinematics.elements.hinge import Hinge
from pyident.kinematics.elements.slider import Slider
from pyident.kinematics.robot_structure import of_robot
from pyident.kinematics.structure import Structure, StructureError

CRANK, ARM, FOREARM = 0.3, 0.8, 1.1
TIP = 5  # translational node
UP, AHEAD = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
# A turning column; on it the lower arm and a crank, side by side and each with its own motor. A rod from
# the crank to the rear of the forearm keeps those two parallel. Hinges about y, triads with y' along x.
ABOUT_Z = np.column_stack([UP, AHEAD, np.cross(UP, AHEAD)])
ABOUT_Y = np.column_stack([np.cross(UP, AHEAD), UP, AHEAD])
PALLETISER = Structure(
    elements=(
        Hinge(0, 1, ABOUT_Z),  # 0  column
        Hinge(1, 2, ABOUT_Y),  # 1  motor of the lower arm
        Beam(0, 2, 1, 3, ARM * UP),
        Hinge(1, 4, ABOUT_Y),  # 3  motor of the crank
        Beam(0, 4, 2, 5, -CRANK * AHEAD),
        Hinge(5, 6, ABOUT_Y),  # 5  crank to rod: free, its bendings too
        Beam(2, 6, 3, 7, ARM * UP),
        Hinge(3, 8, ABOUT_Y),  # 7  elbow: free
        Beam(1, 8, 3, 9, -CRANK * AHEAD),  # rear of the forearm, closes the loop in node 3
        Hinge(7, 9, ABOUT_Y),  # 9  rod to forearm: free, bending across the rod too
        Beam(1, 8, TIP, 10, FOREARM * AHEAD),
    ),
    independent=((0, 0), (1, 0), (3, 0)),
    released=((5, 0), (5, 1), (5, 2), (7, 0), (9, 0), (9, 1)),
)


def states(samples: int = 25) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, dq, ddq (3, samples); the lower arm and the crank stay apart, so the loop never goes flat."""
    rng = np.random.default_rng(11)
    q = np.stack([rng.uniform(-3, 3, samples), rng.uniform(-1, 1, samples), np.zeros(samples)])
    q[2] = q[1] + rng.uniform(-1.2, 1.2, samples)
    return q, rng.normal(size=q.shape), rng.normal(size=q.shape)


def closed_form(q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> list[np.ndarray]:
    """Tip position, velocity, acceleration (3, N): the forearm is parallel to the crank."""
    s, ds, dds = (ca.SX.sym(name, 3) for name in ("q", "dq", "ddq"))
    reach = ARM * ca.sin(s[1]) + FOREARM * ca.cos(s[2])
    tip = ca.vertcat(reach * ca.cos(s[0]), reach * ca.sin(s[0]), ARM * ca.cos(s[1]) - FOREARM * ca.sin(s[2]))
    v = ca.jtimes(tip, s, ds)
    a = ca.jtimes(v, s, ds) + ca.jtimes(tip, s, dds)
    return [np.array(value) for value in ca.Function("tip", [s, ds, dds], [tip, v, a])(q, dq, ddq)]


def test_parallelogram_arm_against_its_closed_form():
    motion = states()
    tip = transfer.nodes(PALLETISER, *motion).positions[TIP]
    for ours, want in zip((tip.x, tip.v, tip.a), closed_form(*motion), strict=True):
        np.testing.assert_allclose(ours, want, rtol=0, atol=1e-12 * max(1, np.abs(want).max()))
    np.testing.assert_allclose(np.einsum("ijn,jn->in", tip.DF, motion[1]), tip.v, atol=1e-13)


def test_released_bendings_stay_zero():
    q, _, _ = states()
    shape = loop.configuration(PALLETISER, q)
    for i, mode in ((5, 1), (5, 2), (9, 1)):
        assert np.abs(PALLETISER.elements[i].D(shape)[mode]).max() < 1e-13
    np.testing.assert_allclose(PALLETISER.elements[7].D(shape)[0], q[2] - q[1], atol=1e-13)


def test_newton_converges_quadratically():
    q, _, _ = states(200)
    shape, errors = loop.reference(PALLETISER, 200), []
    for _ in range(7):
        shape, error = loop.newton(PALLETISER, shape, q / 3)
        errors.append(error.max())
    # 1.0, 0.56, 0.16, 0.014, 1.5e-4, 1.0e-8, 3e-16
    assert errors[0] > 0.9
    assert errors[-1] < 1e-14
    assert all(errors[k + 1] < 2 * errors[k] ** 2 for k in range(2, 5))


def test_loop_DF_and_D2F_against_finite_differences():
    (q, dq, _), h = states(), 1e-6
    still = np.zeros_like(q)
    nodes = loop.nodes(PALLETISER, q, dq, still)
    before, after = (loop.nodes(PALLETISER, q + s * h * dq, dq, still) for s in (-1, 1))
    for i, position in nodes.positions.items():
        v = (after.positions[i].x - before.positions[i].x) / (2 * h)
        a = (after.positions[i].v - before.positions[i].v) / (2 * h)
        np.testing.assert_allclose(np.einsum("ijn,jn->in", position.DF, dq), v, atol=1e-6)
        np.testing.assert_allclose(position.a, a, atol=1e-6)
    for i, orientation in nodes.orientations.items():
        dw = (after.orientations[i].w - before.orientations[i].w) / (2 * h)
        np.testing.assert_allclose(orientation.dw, dw, atol=1e-6)


@pytest.mark.parametrize("robot", [load_robot("four_link"), mixed_robot(1)], ids=lambda robot: robot.name)
def test_newton_and_recursion_agree_on_chains(robot: Robot):
    structure = of_robot(robot)
    assert structure.is_chain
    motion = tuple(rate.T for rate in random_motion(robot, 20))
    recursion, newton = chain.nodes(structure, *motion), loop.nodes(structure, *motion)
    pairs = [(position, newton.positions[i]) for i, position in recursion.positions.items()]
    pairs += [(orientation, newton.orientations[i]) for i, orientation in recursion.orientations.items()]
    for want, got in pairs:
        for field in fields(want):
            expected = getattr(want, field.name)
            scale = max(1.0, np.abs(expected).max())
            np.testing.assert_allclose(getattr(got, field.name), expected, rtol=0, atol=1e-11 * scale)


def test_a_slider_crank():
    """Crank 0.3 m, rod 0.8 m, the piston on the ground's x axis: s = r cos q + √(l² − r² sin² q)."""
    r, length = 0.3, 0.8
    along_x, about_z = np.eye(3), ABOUT_Z
    start = np.array([0.0, r, 0.0])  # the crank stands across the slide in the reference configuration
    rod = np.array([np.sqrt(length**2 - r**2), -r, 0.0])
    structure = Structure(
        elements=(
            Hinge(0, 1, about_z),
            Beam(0, 1, 1, 2, start),
            Hinge(2, 3, about_z),
            Beam(1, 3, 2, 4, rod),
            Slider(0, 0, 2, along_x),
        ),
        independent=((0, 0),),
        released=((2, 0), (4, 0), (4, 2)),
    )
    q = np.linspace(-1.4, 4, 50)[None]
    dq = np.ones_like(q)
    piston = transfer.nodes(structure, q, dq, np.zeros_like(q)).positions[2]
    angle, s = q[0] + np.pi / 2, ca.SX.sym("s")
    stroke = r * ca.cos(s) + ca.sqrt(length**2 - (r * ca.sin(s)) ** 2)
    rate = ca.jacobian(stroke, s)
    want = ca.Function("stroke", [s], [stroke, rate, ca.jacobian(rate, s)])(angle[None])
    for ours, value in zip((piston.x, piston.v, piston.a), want, strict=True):
        np.testing.assert_allclose(ours[0], np.array(value)[0], atol=1e-12)


def test_the_matrix_is_well_conditioned():
    shape = loop.configuration(PALLETISER, states()[0])
    assert np.linalg.cond(assembly.DD(PALLETISER, shape)).max() < 1e3


def test_too_many_held_deformations_are_counted():
    with pytest.raises(StructureError, match="45 held deformations for 42 nodal coordinates; release 3 more"):
        replace(PALLETISER, released=((5, 0), (7, 0), (9, 0)))


def test_a_loop_out_of_reach_is_refused():
    crank, rod = 0.8 * UP, 0.5 * AHEAD
    structure = Structure(
        elements=(
            Hinge(0, 1, ABOUT_Y),
            Beam(0, 1, 1, 2, crank),
            Hinge(2, 3, ABOUT_Y),
            Beam(1, 3, 2, 4, rod),
            Slider(0, 0, 2, np.eye(3)),
        ),
        independent=((0, 0),),
        released=((2, 0), (4, 0), (4, 1)),
    )
    with pytest.raises(StructureError, match=r"does not close at q = \(0.5\)"):
        loop.nodes(structure, np.array([[1.0]]), np.zeros((1, 1)), np.zeros((1, 1)))


def test_a_deformation_listed_twice_is_refused():
    with pytest.raises(StructureError, match="deformation 0 of element 0 is listed twice"):
        replace(PALLETISER, independent=((0, 0), (0, 0), (3, 0)))


def test_an_element_in_the_air_is_refused():
    with pytest.raises(StructureError, match="element 0 starts at a node that none before it reaches"):
        Structure((Hinge(1, 2, ABOUT_Z),), independent=((0, 0),))
