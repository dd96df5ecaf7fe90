"""A link's balance holds no torque: its stiffness and its inertia may change their signs together.

And a spring that is not straight, or about another axis, is no column that is wrong.
"""

from dataclasses import replace

import numpy as np
import pytest

from pyident.checks.balances import Balances, balances, balances_of, samples
from pyident.checks.twists import bends, twists

STIFFNESS = ("joint4.k[2]", "joint4.k[3]")


@pytest.fixture(scope="module")
def sound(four_link, identification_log) -> Balances:
    signals = samples(four_link, identification_log)
    assert signals is not None
    return balances(signals)


def negated(of: Balances, names: set[str]) -> Balances:
    """The same equations of parameters in another sign."""
    sign = np.where([name in names for name in of.columns], -1.0, 1.0)
    return replace(of, Phi=of.Phi * sign, normal=of.normal * np.outer(sign, sign))


def test_a_sound_log_bends_the_right_way(sound):
    assert list(bends(sound, "a log")) == []


@pytest.mark.parametrize("stiffness", STIFFNESS)
def test_a_stiffness_alone_in_another_sign_is_a_column_in_another_sign(sound, stiffness):
    (defect,) = bends(negated(sound, {stiffness}), "a log")
    channel = stiffness.replace(".k[", ".eps[")
    assert (defect.severity, defect.kind, defect.channel) == ("gross", "sign", channel)


def test_a_stiffness_and_the_inertia_that_it_holds_in_another_sign_say_nothing_of_a_column(sound):
    link = {name for name in sound.columns if name.startswith(("link4.", "joint4.k", "joint4.d"))}
    assert link.issuperset(STIFFNESS)
    assert list(bends(negated(sound, link), "a log")) == []


def test_bending_that_fits_with_neither_sign_is_no_column_in_another(sound):
    """As about an axis that is turned: most of what is measured is the bending about the other one."""
    stiffness, at = "joint4.k[2]", sound.samples.robot.coordinates.index("joint4.eps[2]")
    Phi = negated(sound, {stiffness}).Phi.copy()
    column = Phi[:, at, sound.columns.index(stiffness)]
    column += 2.0 * np.std(column) * np.random.default_rng(0).standard_normal(len(column))
    (defect,) = bends(balances_of(sound.samples, Phi, sound.columns), "a log")
    assert (defect.severity, defect.kind, defect.channel) == ("doubtful", "sign", "joint4.eps[2]")
    assert "fits with neither sign" in defect.sentence


def test_a_spring_that_hardens_is_no_other_joints_twist(sound):
    """Joints 3 and 4 are loaded alike, so that the twist of one tells the torque of the other best."""
    robot, signals = sound.samples.robot, sound.samples
    three, four = (robot.coordinates.index(f"joint{k}.eps[1]") for k in (3, 4))
    load, q, tau = signals.q[:, three], signals.q.copy(), signals.tau.copy()
    size = np.std(load)
    q[:, four] = np.cbrt(load / size) * size
    tau[signals.at, 3] = -1e4 * load
    hardened = balances(replace(signals, q=q, tau=tau))
    assert list(twists(hardened, "a log")) == []
    tau[signals.at, 2] = -1e4 * q[:, four]
    exchanged = balances(replace(signals, q=q, tau=tau))
    assert {d.kind for d in twists(exchanged, "a log")} == {"order"}


def test_an_arm_that_shakes_faster_than_its_samples_has_no_sign(sound):
    """The torque goes with a twist of which the link's balance knows nothing."""
    robot, signals = sound.samples.robot, sound.samples
    four = robot.coordinates.index("joint4.eps[1]")
    shaken = 3 * signals.q[:, four].std() * np.random.default_rng(0).standard_normal(len(signals.q))
    q, tau = signals.q.copy(), signals.tau.copy()
    q[:, four] += shaken
    tau[signals.at, 3] += 1e5 * shaken
    shaking = replace(signals, q=q, tau=tau)
    assert list(twists(balances(shaking), "a log")) == []
    turned = signals.q.copy()
    turned[:, four] *= -1
    assert [d.kind for d in twists(balances(replace(signals, q=turned)), "a log")] == ["sign"]
