"""A law of friction is no imitator because the friction of its joint warms up within the log."""

import numpy as np
import pytest
from six_axis_logs import arm, made, plain

from pyident.diagnosis.imitators.constancy import _beside_warming, changes_with
from pyident.diagnosis.searched import searched
from pyident.simulation.fmu_runs import runs_here

WARMS = 0.1  # of joint 1's friction, over a log


def warming(q, v, load, time):
    out = plain(q, v, load, time)
    out[:, 0] *= 1 - WARMS * time / time[-1]
    return out


def sub_linear(q, v, load, time):
    out = warming(q, v, load, time)
    out[:, 0] += 9.0 * (np.sign(v[:, 0]) * np.abs(v[:, 0]) ** 0.5 - v[:, 0])
    return out


@pytest.mark.slow
def test_a_true_law_stays_beside_friction_that_warms_up():
    search = searched(arm(), [made(arm(), seed, sub_linear, 20.0) for seed in (1, 2)], runs_here)
    law = search.best("nonlinear_viscous", 1)
    assert law is not None
    assert dict(law.candidate.values)["power"] == pytest.approx(0.5, abs=0.15)
    assert changes_with(search.with_further([law.candidate]), law.candidate) == ""


@pytest.mark.slow
def test_a_law_that_stands_in_for_warming_is_told():
    search = searched(arm(), [made(arm(), seed, warming, 20.0) for seed in (1, 2)], runs_here)
    drift = search.best("coulomb_drift", 1)
    assert drift is not None
    whole = search.with_further([drift.candidate])
    assert _beside_warming(whole, drift.candidate) is None
