"""A link's balance holds no torque: its stiffness and its inertia may change their signs together."""

from dataclasses import replace

import numpy as np
import pytest

from pyident.checks.balances import Balances, balances, samples
from pyident.checks.twists import bends

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
