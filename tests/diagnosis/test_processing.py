"""A robot file's filter: up to where the data are asked, and no part of what they say."""

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
from scipy.signal import butter, lfilter
from six_axis_logs import COULOMB, VISCOUS, arm, made, three_laws

from flexmodels.settings.processing import Processing
from pyident.diagnosis.diagnose import diagnose
from pyident.logs.log import Log

PLANS = {
    "none": Processing("central"),
    "5 Hz": Processing("central", cutoff=5.0),
    "10 Hz, one sample of five": Processing("central", cutoff=10.0, decimate=5),
    "20 Hz": Processing("central", cutoff=20.0),
}


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def rounded(q, v, load, time):
    """Friction whose sign turns round within a hundredth of the usual speed."""
    return COULOMB * np.tanh(v / 0.004) + VISCOUS * v


def rounded_three_laws(q, v, load, time):
    return three_laws(q, v, load, time) + COULOMB * (np.tanh(v / 0.004) - np.sign(v))


def with_drive_noise(log: Log, rng: np.random.Generator) -> Log:
    """Torques from currents behind a filter of 8 Hz, with 4 % of noise."""
    frame = log.frame.copy()
    low_pass = cast(Any, butter(1, 8.0, fs=1 / log.period))
    for name in [name for name in frame if str(name).endswith(".tau")]:
        tau = frame[name].to_numpy()
        frame[name] = tau + lfilter(
            low_pass[0], low_pass[1], 0.04 * np.std(tau) * rng.standard_normal(len(tau))
        )
    return replace(log, frame=frame)


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS.values(), ids=PLANS.keys())
@pytest.mark.parametrize("friction", [rounded, rounded_three_laws])
def test_a_verdict_is_the_same_whatever_the_filter(plan, friction):
    robot, rng = arm().with_settings(processing=plan), np.random.default_rng(1)
    logs = [with_drive_noise(made(arm(), seed, friction), rng) for seed in (0, 5)]
    found = diagnose(robot, logs[:1], never, logs[1:])
    first = {(f.tie[0].effect, f.tie[0].joint) for f in found.findings}
    truth = {
        ("load_dependent_friction", "joint2"),
        ("load_dependent_friction", "joint3"),
        ("nonlinear_viscous", "joint1"),
    }
    assert first == (set() if friction is rounded else truth)
    if friction is rounded:
        assert all(place.state != "unexplained" for place in found.places)
