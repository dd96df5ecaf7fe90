"""Every element's D(x): its derivatives against finite differences, and the rigid motions it ignores."""

import numpy as np
import pytest

from pyident.kinematics.elements.beam import Beam
from pyident.kinematics.elements.hinge import Hinge
from pyident.kinematics.elements.nodes import Shape, Velocity
from pyident.kinematics.elements.slider import Slider
from pyident.kinematics.elements.triads import compose, rotate, turn
from pyident.kinematics.structure import Element

SAMPLES = 40
RNG = np.random.default_rng(7)
TRIAD = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
TRIAD[:, 2] = np.cross(TRIAD[:, 0], TRIAD[:, 1])
ELEMENTS: list[Element] = [
    Hinge(1, 2, TRIAD),
    Slider(1, 1, 2, TRIAD),
    Beam(1, 1, 2, 2, np.array([0.3, -0.5, 0.8])),
]
elements = pytest.mark.parametrize("element", ELEMENTS, ids=lambda element: type(element).__name__)


def normal(scale: float = 1.0) -> np.ndarray:
    return scale * RNG.normal(size=(3, SAMPLES))


def deformed(element: Element) -> Shape:
    """The element anywhere in space, its deformations of the order of 0.3."""
    R = turn(normal())
    shape: Shape = {("R", 1): R, ("R", 2): compose(turn(normal(0.2)), R), ("x", 1): normal()}
    vector = element.vector[:, None] if isinstance(element, Beam) else np.zeros((3, 1))
    shape["x", 2] = shape["x", 1] + rotate(R, vector) + normal(0.2)
    return shape


def velocities() -> Velocity:
    return {(kind, i): normal() for kind in ("x", "R") for i in (1, 2)}


def moved(shape: Shape, velocity: Velocity, time: float) -> Shape:
    """At constant v and ω."""
    return {
        node: value + time * velocity[node] if node[0] == "x" else compose(turn(time * velocity[node]), value)
        for node, value in shape.items()
    }


@elements
def test_DD_is_the_rate_of_D(element: Element):
    shape, velocity, h = deformed(element), velocities(), 1e-5
    stacked = np.concatenate([velocity[node] for node in element.inner + element.outer])
    want = (element.D(moved(shape, velocity, h)) - element.D(moved(shape, velocity, -h))) / (2 * h)
    np.testing.assert_allclose(np.einsum("ijn,jn->in", element.DD(shape), stacked), want, atol=1e-8)


@elements
def test_D2D_is_the_second_rate_of_D(element: Element):
    shape, velocity, h = deformed(element), velocities(), 1e-5

    def rate(time: float) -> np.ndarray:
        stacked = np.concatenate([velocity[node] for node in element.inner + element.outer])
        return np.einsum("ijn,jn->in", element.DD(moved(shape, velocity, time)), stacked)

    np.testing.assert_allclose(element.D2D(shape, velocity), (rate(h) - rate(-h)) / (2 * h), atol=1e-7)


@elements
def test_a_rigid_motion_deforms_nothing(element: Element):
    shape, w, v = deformed(element), normal(), normal()
    R = turn(w)
    displaced = {n: rotate(R, value) + v if n[0] == "x" else compose(R, value) for n, value in shape.items()}
    np.testing.assert_allclose(element.D(displaced), element.D(shape), atol=1e-13)


def test_the_modes_of_a_beam():
    """Stretch, twist and the end slopes of a beam along x, to first order in the nodes' motion."""
    beam, small = Beam(0, 0, 1, 1, np.array([2.0, 0.0, 0.0])), 1e-6
    y, z = beam.triad[:, 1], beam.triad[:, 2]
    at_p: Shape = {("x", 0): np.zeros((3, 1)), ("R", 0): np.eye(3)[:, :, None]}

    def D(stretch: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        at_q: Shape = {("x", 1): (beam.vector + stretch)[:, None], ("R", 1): turn(rotation[:, None])}
        return beam.D(at_p | at_q)[:, 0]

    x, none = np.array([1.0, 0.0, 0.0]), np.zeros(3)
    np.testing.assert_allclose(D(none, none), 0, atol=1e-15)
    np.testing.assert_allclose(D(small * x, none), [small, 0, 0, 0, 0, 0], atol=1e-11)
    np.testing.assert_allclose(D(none, small * x), [0, 2 * small, 0, 0, 0, 0], atol=1e-11)
    np.testing.assert_allclose(D(small * y, none), [0, 0, 0, 0, small, -small], atol=1e-11)
    np.testing.assert_allclose(D(small * z, none), [0, 0, -small, small, 0, 0], atol=1e-11)
    np.testing.assert_allclose(D(none, small * z), [0, 0, 0, 0, 0, 2 * small], atol=1e-11)
    np.testing.assert_allclose(D(none, small * y), [0, 0, 0, 2 * small, 0, 0], atol=1e-11)


def test_a_beam_without_length_is_refused():
    with pytest.raises(ValueError, match="from node 1 to 2 has no length"):
        Beam(1, 1, 2, 2, np.zeros(3))
