"""Rotor and link about one axis: which joints cannot tell them apart, and what stays the same."""

import numpy as np
import pytest
from studies.log_checks.swings import six_axes
from studies.rigid_arm.pinocchio_chain import chain, inverse_dynamics, pinocchio

from pyident.conditioning.motion import Motion
from pyident.regression.loads.bodies import link_torques
from pyident.regression.loads.rotor_share import open_shares
from pyident.regression.regressor import generalised_forces

ROBOT = six_axes()
RNG = np.random.default_rng(4)
MOTION = Motion(*(RNG.uniform(-1, 1, (50, 6)) for _ in range(3)))


def forces(robot):
    return generalised_forces(robot, MOTION, np.array(list(robot.linear_parameters.values())))


def test_only_axes_that_no_joint_before_them_turns_are_open():
    """Of the arm the vertical first axis, and the second, which stands across it; the third is parallel."""
    assert [share.joint for share in open_shares(ROBOT, [MOTION])] == [1, 2]


@pytest.mark.parametrize("number", [0, 1])
def test_a_moved_share_changes_the_load_by_the_inertia_and_no_torque(number):
    share = open_shares(ROBOT, [MOTION])[number]
    moved = share.moved(ROBOT, 0.3)
    np.testing.assert_allclose(forces(moved), forces(ROBOT), atol=1e-9 * np.abs(forces(ROBOT)).max())
    fall = (link_torques(ROBOT, MOTION) - link_torques(moved, MOTION))[:, share.joint - 1]
    np.testing.assert_allclose(fall, 0.3 * MOTION.ddq[:, share.joint - 1], atol=1e-9)


def test_its_ends_are_a_rotor_and_a_link_without_inertia():
    first = open_shares(ROBOT, [MOTION])[0]
    assert first.ends[0] == -ROBOT.parameters["joint1.J_m"]
    model = chain(ROBOT, np.ones(len(ROBOT.links)))
    data = model.createData()
    inertia = [pinocchio().crba(model, data, q)[0, 0] for q in MOTION.q]
    assert first.ends[1] == pytest.approx(min(inertia), rel=1e-6)


def test_pinocchio_knows_the_loads():
    still = np.zeros_like(MOTION.q)
    expected = inverse_dynamics(chain(ROBOT, np.ones(len(ROBOT.links))), MOTION.q, still, still)
    np.testing.assert_allclose(link_torques(ROBOT, Motion(MOTION.q, still, still)), expected, atol=1e-6)


def test_where_a_fit_has_no_inertia_there_is_nothing_to_share():
    bent = ROBOT.with_parameters({"joint1.J_m": -1000.0})
    assert [share.joint for share in open_shares(bent, [MOTION])] == [2]
