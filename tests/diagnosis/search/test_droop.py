"""A drive whose current rises faster than its torque is told from friction, and from a hard limit."""

from dataclasses import replace

import numpy as np
import pytest
from six_axis_logs import arm, made, plain

from pyident.diagnosis.diagnose import diagnose
from pyident.logs.log import Log

PACE = 2.0  # times a slow motion
JOINT = "joint2"


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def with_torque(log: Log, tau: np.ndarray) -> Log:
    return replace(log, frame=log.frame.assign(**{f"{JOINT}.tau": tau}))


def saturating(log: Log) -> Log:
    """What a constant makes of the current where T = K i/(1 + i/i0), which loses a fifth at the peak."""
    tau = log.frame[f"{JOINT}.tau"].to_numpy()
    knee = 5.0 * float(np.abs(tau).max())
    return with_torque(log, tau / (1 - np.abs(tau) / knee))


def limited(log: Log) -> Log:
    """Above seven tenths of the peak the drive gives half of what it is asked for."""
    tau = log.frame[f"{JOINT}.tau"].to_numpy()
    limit = 0.7 * float(np.abs(tau).max())
    return with_torque(log, tau + np.sign(tau) * np.maximum(np.abs(tau) - limit, 0))


@pytest.mark.slow
@pytest.mark.parametrize(("spoilt", "name"), [(saturating, "torque_droop"), (limited, "torque_saturation")])
def test_the_way_in_which_a_drive_saturates_is_named(spoilt, name):
    logs = [spoilt(made(arm(), seed, plain, 20.0, PACE)) for seed in range(2)]
    found = diagnose(arm(), logs[:1], never, logs[1:])
    assert [(n.effect, n.joint) for n in found.findings[0].tie] == [(name, JOINT)]
    assert len(found.findings) == 1
