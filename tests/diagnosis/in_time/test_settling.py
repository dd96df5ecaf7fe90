"""Friction that warms up along an exponential, in every log from cold: its law, and its time."""

import numpy as np
import pytest
from six_axis_logs import arm, made, plain
from studies.rigid_arm.arm import VISCOUS

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched

SETTLES, COLD = 8.0, 1.5  # s; times the viscous friction that a cold joint has more
DURATION = 30.0


def warming(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """At joint 2."""
    out = plain(q, v, load, time)
    out[:, 1] += COLD * VISCOUS[1] * np.exp(-time / SETTLES) * v[:, 1]
    return out


def never(_):
    raise AssertionError("nothing is simulated here")


def test_friction_that_warms_up_has_its_time_and_its_size():
    logs = [made(arm(), seed, warming, DURATION, 6.0) for seed in range(3)]
    found = concluded(searched(arm(), logs[:2], never), never, logs[2:])
    (finding,) = found.findings
    law = finding.tie[0]
    assert (law.effect, law.joint) == ("viscous_drift", "joint2")
    assert finding.share_percent > 90
    assert law.values["settling"] == pytest.approx(SETTLES, rel=0.3)
    fall = -law.values["drift"] * law.values["settling"]
    assert fall == pytest.approx(COLD * VISCOUS[1], rel=0.2)


def test_a_straight_drift_stays_one():
    """Its time is far beyond the log, where the curve is a line."""

    def straight(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
        out = plain(q, v, load, time)
        out[:, 1] -= 0.6 * VISCOUS[1] * time / DURATION * v[:, 1]
        return out

    logs = [made(arm(), seed, straight, DURATION, 6.0) for seed in range(3)]
    found = concluded(searched(arm(), logs[:2], never), never, logs[2:])
    (finding,) = found.findings
    law = finding.tie[0]
    assert (law.effect, law.joint) == ("viscous_drift", "joint2")
    assert law.values["settling"] > 2 * DURATION
    assert law.values["drift"] == pytest.approx(-0.6 * VISCOUS[1] / DURATION, rel=0.3)
