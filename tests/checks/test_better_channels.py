"""Whether a change of the channels is believed."""

from types import SimpleNamespace
from typing import Any

import pytest

from pyident.checks.better_channels import Misfit, _suits_one


@pytest.mark.parametrize(
    ("before", "after", "alone"),
    [
        ({0: 1e-4, 3: 4e-4, 5: 0.14}, {0: 1e-4, 3: 8e-4, 5: 0.01}, True),  # joint 4 itself is worse
        ({0: 1e-4, 3: 4e-4, 5: 0.14}, {0: 9e-4, 3: 4e-4, 5: 0.01}, True),  # all others together are
        ({0: 0.02, 3: 0.03, 5: 0.14}, {0: 1e-4, 3: 4e-4, 5: 0.01}, False),
        ({3: 0.3}, {3: 0.01}, False),
    ],
)
def test_what_suits_another_joint_alone_is_no_change_of_this_one(before, after, alone):
    change: Any = SimpleNamespace(joints=[3])
    assert _suits_one(Misfit(after), Misfit(before), change) == alone
