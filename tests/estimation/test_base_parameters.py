"""Combinations that the data determine, written out."""

import numpy as np
import pytest
from studies.rigid_arm.arm import COULOMB, ROTOR, VISCOUS, arm, moved, recorded

from pyident.conditioning.weak_form import condition
from pyident.estimation.base_parameters import BaseParameter, base_parameters, hardly_told
from pyident.estimation.estimator import weighted
from pyident.regression.equations import Problem

pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")


def truth(robot):
    values = dict(robot.parameters)
    for k in range(6):
        joint = f"joint{k + 1}"
        values |= {f"{joint}.coulomb": COULOMB[k], f"{joint}.viscous": VISCOUS[k]}
        values |= {f"{joint}.J_m": ROTOR[k], f"{joint}.offset": 0.0}
    return values


@pytest.mark.parametrize("seed", [1, 5])
def test_an_expression_has_every_term_that_the_data_see(seed):
    """A mass at 8 mm weighs a thousandth of an inertia's column, and many of its standard deviations."""
    rng, robot = np.random.default_rng(seed), arm()
    motion = moved(robot, rng, 12.0)
    tau = motion.load + ROTOR * motion.a + COULOMB * np.sign(motion.v) + VISCOUS * motion.v
    log = recorded(motion, tau, np.full(6, 1e-3), rng, "log")
    log.frame[list(robot.coordinates)] = motion.q
    found = weighted(Problem(robot, (condition(log, robot),))).with_long_memory()
    true, base = truth(robot), base_parameters(found.reduced, found.solution)
    z = [(b.value - sum(f * true[name] for f, name in b.terms)) / b.std for b in base]
    assert len(z) > 50
    assert np.abs(z).max() < 6  # intervals are Newey and West's, a little short


def test_values_that_noise_alone_may_make_are_named_the_loosest_first():
    told = [
        BaseParameter(((1.0, "joint1.J_m"),), 0.4, 0.01),
        BaseParameter(((1.0, "link2.J[xy]"),), -202.0, 270.0),
        BaseParameter(((1.0, "link2.J[xz]"), (2.0, "link3.m")), 0.3, 0.4),
    ]
    (note,) = hardly_told(told)
    assert note.startswith("2 of 3 values are no larger than noise may make them, as ")
    assert "link2.J[xy] = -202; link2.J[xz] + 2 link3.m = 0.3:" in note
    assert hardly_told(told[:1]) == ()
