"""Which of two torques that share a body is in another unit: the robot file's masses are the witness."""

from types import SimpleNamespace
from typing import Any

import pytest

from pyident.checks import scale


@pytest.mark.parametrize(
    ("told", "blamed"),
    [
        ({0: 1.0, 1: 1.0, 2: 1e-3, 3: 1.1}, (1000.0, 2)),
        ({0: 1.0, 1: 1.0, 2: 1.2, 3: 1000.0}, (1e-3, 3)),
        ({0: 1.0, 1: 1.0, 2: 1.2, 3: 1.1}, (1e-3, 3)),
        ({0: 1.0, 1: 1.0, 2: 1e-3, 3: None}, (1e-3, 3)),  # where the masses say nothing of a torque
    ],
)
def test_masses_tell_which_of_two_torques_is_in_another_unit(monkeypatch, told, blamed):
    """Joint 4's torque agrees with joint 3's once it is a thousandth; the other way round just as well."""
    monkeypatch.setattr(scale, "file_factor", lambda _, joints: told[joints[0]])
    of: Any = SimpleNamespace(joints=list(told))
    assert scale._by_masses(of, 1e-3, 3) == pytest.approx(blamed)
