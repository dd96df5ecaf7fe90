"""Coefficients of friction that grows with the load, which the bodies make that are fitted beside it."""

import numpy as np
import pytest
from six_axis_logs import arm, made, plain
from two_link_logs import in_process

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.coefficients import gain_beside
from pyident.diagnosis.searched import searched

COEFFICIENT = 0.14
LAWS = [Candidate("load_dependent_friction", joint) for joint in (1, 2, 3)]


def rubbing(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Friction under load at the first three joints; the first one's axis is vertical."""
    out = plain(q, v, load, time)
    out[:, :3] += COEFFICIENT * np.abs(load[:, :3]) * np.sign(v[:, :3])
    return out


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_they_lie_within_their_deviations(seed):
    """At the first joint the friction alone tells how much of the inertia is the rotor's, and says so."""
    search = searched(arm(), [made(arm(), seed, rubbing, duration=40.0)], in_process)
    for law, widest in zip(LAWS, (0.03, 0.002, 0.002), strict=True):
        found = gain_beside(search, [other for other in LAWS if other is not law], law)
        (value,), (std,) = found.coefficients, found.std
        assert std < widest
        assert value == pytest.approx(COEFFICIENT, abs=3 * std)
