"""An error of the robot file that hardly exceeds the floor must be in held-out logs at its size."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from pyident.diagnosis.search.held_out import Unseen
from pyident.diagnosis.search.wrong_description import _no_chance
from pyident.rules.rules import RULES

VIEW: Any = SimpleNamespace(rules=RULES.search)


@pytest.mark.parametrize(
    ("unseen", "no_chance"),
    [
        (Unseen(0.19, 0.01, 0.02, 1.0), True),
        (Unseen(0.19, 0.01, 0.02, 3.8), False),  # 2.4 times its size: it stands in for something else
        (Unseen(0.19, 0.05, 0.02, 1.0), False),  # perhaps by chance
        (None, False),
    ],
)
def test_an_imitator_of_little_has_another_size_on_other_logs(unseen, no_chance):
    entry = SimpleNamespace(unseen=unseen)
    assert _no_chance(VIEW, cast(Any, entry)) == no_chance
