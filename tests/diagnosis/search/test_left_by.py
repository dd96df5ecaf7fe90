"""A further effect that only mends the form of one named already is none."""

from types import SimpleNamespace
from typing import Any, cast

import pytest
from six_axis_logs import arm

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.search.found import Step
from pyident.diagnosis.search.selection import _left_by
from pyident.rules.rules import RULES


def found(effect: str, energy: float = 100.0, **values: float) -> Any:
    return SimpleNamespace(
        candidate=Candidate(effect, 1, tuple(values.items())), gain=SimpleNamespace(energy=energy)
    )


def step(*tie: Any) -> Step:
    return cast(Any, SimpleNamespace(best=tie[0], tie=tie))


def view(left: float) -> Any:
    """What the rivals of others leave of any further gain."""
    beside = SimpleNamespace(gain_of=lambda _: SimpleNamespace(energy=left))
    return SimpleNamespace(with_further=lambda _: beside, rules=RULES.search, robot=arm())


SPRING, GRAVITY = found("joint_spring"), found("gravity_spring", ratio=1.0, phase=0.0)
RIPPLE = found("torque_ripple", order=200.0)
STRIBECK = found("stribeck", velocity=0.1)


@pytest.mark.parametrize(
    ("further", "other", "left", "said"),
    [
        (step(found("torque_saturation"), STRIBECK), step(STRIBECK), 100.0, "stribeck at joint1"),
        (step(RIPPLE), step(SPRING, GRAVITY), 20.0, "joint_spring at joint1"),  # a gravity spring takes most
        (step(RIPPLE), step(SPRING, GRAVITY), 90.0, ""),
        (step(RIPPLE), step(SPRING), 0.0, ""),  # nothing that the spring could not be told from
        (step(STRIBECK, RIPPLE), step(found("torque_ripple", order=12.0)), 100.0, ""),  # of another order
    ],
)
def test_what_a_named_law_leaves_of_another_form(further, other, left, said):
    assert _left_by(view(left), further, [other]) == said
