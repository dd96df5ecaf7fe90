"""A law is added to logs whose positions come late as a diagnosis names it there: behind the same mending."""

import numpy as np
import pytest
from six_axis_logs import arm, late, made, plain

import pyident as pi

COEFFICIENT = 0.12


def loaded(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Load-dependent friction at joint 2."""
    out = plain(q, v, load, time)
    out[:, 1] += COEFFICIENT * np.abs(load[:, 1]) * np.sign(v[:, 1])
    return out


def test_late_positions_are_put_right_before_a_law_is_fitted():
    logs = [late(made(arm(), seed, loaded, 20.0, 6.0), 0.9) for seed in range(2)]
    found = pi.add_effect(arm(), "load_dependent_friction", 2, logs)
    assert found.accepted, found.headline()
    assert [note for note in found.notes if "late against the torques; that was put right" in note]
    coefficient = found.robot.parameters["joint2.load_dependent_friction.coefficient"]
    assert coefficient == pytest.approx(COEFFICIENT, rel=0.1)
    assert found.robot.settings.processing == arm().settings.processing
