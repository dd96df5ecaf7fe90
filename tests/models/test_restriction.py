"""Laws at joints that have less than they ask for."""

import pytest
from sympy import Symbol

from flexmodels.effects import CATALOGUE, signals
from flexmodels.effects.restriction import objection, restricted


def test_a_joint_that_only_twists_keeps_one_stiffness():
    law = restricted(CATALOGUE["stiffness"], (1,))
    assert [p.name for p in law.parameters] == ["k[1]"]
    assert set(law.forces) == {signals.eps[1]}


def test_a_whole_joint_keeps_its_law():
    assert restricted(CATALOGUE["stiffness"], (1, 2, 3)) is CATALOGUE["stiffness"]


def test_a_rigid_joint_carries_its_links_too():
    assert restricted(CATALOGUE["load_dependent_friction"], ()) is CATALOGUE["load_dependent_friction"]


@pytest.mark.parametrize(
    ("effect", "deformations", "kind", "k", "said"),
    [
        ("stiffness_coupling", (1,), "revolute", 1, None),
        ("hardening_stiffness", (), "revolute", 1, "deformations that joint 1 has not"),
        ("joint_coupling", (1, 2, 3), "revolute", 4, "joint 4 is the last"),
        ("payload", (1, 2, 3), "revolute", 2, "put it at the last joint, 4"),
        ("gravity_spring", (), "prismatic", 1, "joint 1 is prismatic"),
    ],
)
def test_objections(effect, deformations, kind, k, said):
    found = objection(CATALOGUE[effect], deformations, kind, k, 4)
    if said is None:
        assert found is None or "deformations" in found
    else:
        assert found is not None
        assert said in found


def test_dahls_state_follows_the_travel():
    """Along one direction z = 1 − exp(−x/travel): dz/dx is 1/travel at the reversal and 0 far beyond."""
    (state,) = CATALOGUE["presliding"].states
    travel = next(p for p in CATALOGUE["presliding"].parameters if p.grid)
    rate = state.rate.subs({signals.de: 2.0, travel.symbol: 0.01})
    z = Symbol(state.name, real=True)
    assert float(rate.subs(z, 0.0)) == pytest.approx(2.0 / 0.01)
    assert float(rate.subs(z, 1.0)) == pytest.approx(0.0)
