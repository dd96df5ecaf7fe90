"""An equation stands out if it leaves by far more than replicas do, and more than any of them."""

from typing import Any

import numpy as np
import pytest

from pyident.diagnosis.base.projection import Base
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.diagnosis.search.search import Search
from pyident.rules.rules import RULES

SAMPLES = 100
CALM, WILD = [1.0] * 20, [0.2] * 19 + [16.2]  # energy that each of 20 replicas leaves: on average 1


class Fitted:
    rules = RULES


def standing_out(energy: float, replicas: list[float]) -> bool:
    """Of one equation whose residual has this mean square."""
    setting: Any = Fitted()
    count, nothing = np.array([SAMPLES]), np.zeros((20, 0))
    left = np.reshape(replicas, (20, 1, 1))
    floor: Any = None
    residual = np.full((1, SAMPLES), np.sqrt(energy))
    base = Base(np.zeros(0), np.zeros((0, 0)), [], [residual])
    examination = Examination(setting, floor, [], base, [], [], nothing, np.array([[energy]]), left, count)
    families: Any = None
    return bool(Search(examination, families, base).standing_out[0])


@pytest.mark.parametrize(
    ("energy", "replicas", "stands_out"),
    [(1.9, CALM, False), (2.1, CALM, True), (15.0, WILD, False), (17.0, WILD, True)],
)
def test_what_a_perfect_model_leaves_as_well_does_not_stand_out(energy, replicas, stands_out):
    assert standing_out(energy, replicas) == stands_out
