"""The reaction of a lumped body against Newton and Euler at its centre of mass, written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pyident.kinematics.elements.body import reaction
from pyident.kinematics.elements.nodes import Orientation, Position

GRAVITY = np.array([0.3, -0.2, -9.81])


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 100_000))
def test_force_and_moment(seed):
    """F = m (a_c − g); M about the node = d/dt(I_c ω) + r × m (a_c − g)."""
    rng = np.random.default_rng(seed)
    R = Rotation.from_rotvec(rng.standard_normal(3)).as_matrix()
    a, w, dw = rng.standard_normal((3, 3))
    m, r = rng.uniform(0.5, 5), rng.standard_normal(3)  # centre of mass in the link's axes
    L = rng.standard_normal((3, 3))
    I_c = L @ L.T
    about_node = I_c + m * (r @ r * np.eye(3) - np.outer(r, r))
    parameters = np.r_[m, m * r, about_node[np.triu_indices(3)]]

    unmoved = np.zeros((3, 1, 1))
    position = Position(np.zeros((3, 1)), np.zeros((3, 1)), a[:, None], unmoved)
    orientation = Orientation(R[:, :, None], w[:, None], dw[:, None], unmoved)
    found = reaction(position, orientation, GRAVITY)[:, :, 0] @ parameters

    arm = R @ r
    a_c = a + np.cross(dw, arm) + np.cross(w, np.cross(w, arm))
    inertia = R @ I_c @ R.T
    force = m * (a_c - GRAVITY)
    moment = inertia @ dw + np.cross(w, inertia @ w) + np.cross(arm, force)
    assert found[:3] == pytest.approx(force)
    assert found[3:] == pytest.approx(moment)
