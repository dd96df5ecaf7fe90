"""Columns of laws against their formulas, and what a law lacks, in a sentence."""

import numpy as np
import pytest
import sympy
from one_joint import one_joint

from flexmodels.effects import CATALOGUE
from pyident.conditioning.motion import Motion
from pyident.regression.laws import Signals, compiled, law_columns
from pyident.regression.loads.bodies import body_columns

TIME = np.arange(200) * 0.01
Q, DQ, DDQ = np.sin(3 * TIME)[:, None], 3 * np.cos(3 * TIME)[:, None], -9 * np.sin(3 * TIME)[:, None]
MOTION = Motion(Q, DQ, DDQ, np.zeros((200, 1)), TIME)


def column(effect: str, parameter: str, motion: Motion = MOTION, **values: float) -> np.ndarray:
    known = Signals(one_joint(), motion)
    listed = law_columns(one_joint(), known, 1, CATALOGUE[effect], values)
    (found,) = [one for one in listed if one.parameter == parameter]
    assert found.row == 0
    return found.value(slice(None))


def test_columns_are_the_laws_formulas():
    np.testing.assert_allclose(column("viscous", "viscous"), DQ[:, 0])
    np.testing.assert_allclose(column("coulomb", "coulomb"), np.sign(DQ[:, 0]))
    np.testing.assert_allclose(column("motor_inertia", "J_m"), DDQ[:, 0])
    settled = 0.5 * (1 - np.exp(-TIME / 0.5))
    np.testing.assert_allclose(column("viscous_drift", "drift", settling=0.5), settled * DQ[:, 0])
    np.testing.assert_allclose(column("coulomb_drift", "rate", settling=0.5), settled * np.sign(DQ[:, 0]))
    np.testing.assert_allclose(column("offset_drift", "rate", settling=1e6), TIME, rtol=1e-5)


def test_a_payload_is_a_body_at_the_tip():
    """A point m at r has m, m r and m (r² 1 - r rᵀ) of its link; a body is many points."""
    columns = body_columns(one_joint(), CATALOGUE["payload"])
    tip = np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(columns["mass"], _body(tip[None], np.ones(1)), atol=1e-12)
    ways, masses = np.random.default_rng(3).uniform(-0.3, 0.3, (5, 3)), np.array([0.2, 0.5, 0.1, 0.4, 0.3])
    about_tip, wanted = _body(ways, masses), _body(ways + tip, masses)
    np.testing.assert_allclose(np.column_stack(list(columns.values())) @ about_tip, wanted, atol=1e-12)


def _body(places: np.ndarray, masses: np.ndarray) -> np.ndarray:
    """(10,) m, ms and J of points at places (N, 3) about their origin."""
    J = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for r, m in zip(places, masses, strict=True))
    return np.array([masses.sum(), *(masses @ places), *np.asarray(J)[np.triu_indices(3)]])


def test_an_expression_is_a_function_of_its_symbols_by_name():
    x, y = sympy.symbols("y x")
    names, value = compiled(sympy.Max(x, 2 * y))
    assert names == ("x", "y")
    np.testing.assert_allclose(value(np.array([1.0, 5.0]), np.array([4.0, 4.0])), [4.0, 10.0])


def test_what_a_law_lacks_is_said():
    with pytest.raises(ValueError, match=r"effect torque_ripple at joint 1 needs a value of its order"):
        column("torque_ripple", "cosine")
    with pytest.raises(ValueError, match="needs the signal time, which the motion of robot one_joint"):
        column("viscous_drift", "drift", Motion(Q, DQ, DDQ), settling=0.5)
