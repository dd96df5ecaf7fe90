"""A six-axis arm whose gears ripple while its friction is not what the model has: both are named."""

import numpy as np
import pytest
from six_axis_logs import arm, made, plain

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched

AMPLITUDE, ORDER = 1.5, 202.0  # N m; per turn


def never(_):
    raise AssertionError("nothing is simulated where the loop is unknown")


def much(q, v, load, time):
    """Ripples at joints 1 to 3, sub-linear viscous friction at joint 1, a load's at joints 2 and 3."""
    out = plain(q, v, load, time)
    out[:, :3] += AMPLITUDE * np.cos(ORDER * q[:, :3] + np.arange(3))
    out[:, 0] += 9.0 * (np.sign(v[:, 0]) * np.abs(v[:, 0]) ** 0.5 - v[:, 0])
    out[:, 1:3] += 0.12 * np.abs(load[:, 1:3]) * np.sign(v[:, 1:3])
    return out


@pytest.fixture(scope="module")
def found():
    return concluded(searched(arm(), [made(arm(), 1, much)], never), never, [made(arm(), 2, much)])


def test_friction_is_found_behind_ripples_that_are_much_louder(found):
    named = {(n.effect, n.joint) for f in found.findings for n in f.tie}
    assert {("nonlinear_viscous", "joint1"), ("load_dependent_friction", "joint2")} <= named


def test_every_ripple_has_its_order_and_size(found):
    ripples = [f.tie[0] for f in found.findings if f.tie[0].effect == "torque_ripple"]
    assert sorted(n.joint for n in ripples) == ["joint1", "joint2", "joint3"]
    for n in ripples:
        assert n.values["order"] == pytest.approx(ORDER, abs=0.05)
        assert np.hypot(n.values["cosine"], n.values["sine"]) == pytest.approx(AMPLITUDE, rel=0.02)


def test_nothing_else_is_named(found):
    true = {("torque_ripple", f"joint{k}") for k in (1, 2, 3)} | {("nonlinear_viscous", "joint1")}
    true |= {("load_dependent_friction", f"joint{k}") for k in (2, 3)}
    assert all(true & {(n.effect, n.joint) for n in f.tie} for f in found.findings)


def test_what_is_not_named_is_unexplained(found):
    named = {n.joint for f in found.findings for n in f.tie if n.effect == "load_dependent_friction"}
    unexplained = {p.joint for p in found.places if p.state == "unexplained"}
    assert "joint3" in named | unexplained
