"""What a diagnosis may name: laws, errors of the description; the motion that these are evaluated along."""

from dataclasses import replace

import numpy as np
from pinocchio_model import PinocchioRobot
from six_axis_logs import arm, made
from two_link_logs import two_link

from flexmodels.files.robot_file import load_robot
from pyident.conditioning.smooth_motion import without_noise
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import (
    Candidate,
    described,
    law_of,
    motion_for,
    slopes,
    units_of,
)
from pyident.diagnosis.base.nonlinear_values import proper
from pyident.regression.regressor import generalised_forces


def test_a_description_is_a_law_with_one_parameter():
    robot = load_robot("four_link")
    law = law_of(robot, Candidate("axis[y]", 2))
    assert [(p.name, p.unit) for p in law.linear] == [("correction", "rad")]
    assert not law.nonlinear
    assert units_of(robot, Candidate("stribeck", 2))["velocity"] == "rad/s"


def test_the_load_of_a_rigid_joint_is_what_the_links_need():
    """Not the measured torque, nor the model's own: both hold friction, which would then explain itself."""
    robot = arm()
    motion = condition(made(robot, 0, duration=5.0), robot).motion
    oracle = PinocchioRobot(robot)
    quiet = without_noise(motion)
    links = np.array([oracle.inverse_dynamics(*x) for x in zip(quiet.q, quiet.dq, quiet.ddq, strict=True)])
    (column,) = slopes(robot, Candidate("load_dependent_friction", 2), motion).values()
    sliding = np.abs(motion.dq[:, 1]) > 0.05
    expected = np.abs(links[:, 1]) * np.sign(motion.dq[:, 1])
    np.testing.assert_allclose(column[1][sliding], expected[sliding], atol=1e-6 * np.abs(links).max())


def test_a_delay_that_no_clock_would_tell_is_none():
    late = Candidate("torque_delay", 1, (("delay", 1e-3),))
    assert proper(arm(), late, [1.0], {}, 0.004)
    assert not proper(arm(), late, [0.05], {}, 0.004)
    assert not proper(arm(), late, [1.0], {}, 0.1)


def test_friction_that_a_power_below_one_lowers_is_no_friction():
    """Beside dry and viscous friction it would be what slow motion takes in excess: Stribeck's."""
    for power, coefficient, so in (
        (0.5, 1.0, True),
        (0.5, -1.0, False),
        (2.0, -1.0, True),
        (1.0, 1.0, False),
    ):
        law = Candidate("nonlinear_viscous", 1, (("power", power),))
        assert proper(arm(), law, [coefficient], {}, 0.004) == so


def test_a_law_of_the_torque_gets_the_models():
    """The measured one has the noise that the law would explain."""
    robot = arm()
    motion = condition(made(robot, 0, duration=5.0), robot).motion
    given = motion_for(robot, Candidate("torque_saturation", 2), motion)
    assert given.tau is not None
    p = np.array(list(robot.linear_parameters.values()))
    np.testing.assert_allclose(given.tau, generalised_forces(robot, motion, p))
    assert motion_for(robot, Candidate("stribeck", 2), motion) is motion
    needed = np.ones_like(given.tau)  # of a fit, which bodies found by friction under load are not
    fitted = motion_for(robot, Candidate("torque_saturation", 2), replace(motion, needed=needed))
    assert fitted.tau is needed


def test_nothing_of_the_robot_file_is_suspected_at_a_joint_that_stands_still():
    """Gravity's direction is not that joint's: it stays."""
    robot = two_link()
    every, moving = set(described(robot)), set(described(robot, still=[1]))
    assert {c.joint for c in every} == {1, 2}
    assert {c.effect for c in moving if c.joint == 1} == {c.effect for c in every if "tilt" in c.effect}
    assert {c for c in moving if c.joint == 2} == {c for c in every if c.joint == 2}
