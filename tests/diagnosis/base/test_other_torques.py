"""What slow noise alone might excuse, but noise does not follow another joint's torque."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt
from six_axis_logs import arm, made, plain

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched


def never(_):
    raise AssertionError("nothing is simulated where the loop is unknown")


def crosstalk(log, _):
    """A hundredth of a neighbour's torque."""
    return 0.01 * log.frame["joint2.tau"].to_numpy()


def slow_noise(log, seed):
    """Of amplifiers."""
    white = np.random.default_rng(seed).standard_normal(len(log.frame) + 2000)
    noise = np.asarray(sosfilt(butter(2, 1.0, fs=1 / log.period, output="sos"), white))[2000:]
    return 0.004 * log.frame["joint2.tau"].std() * noise / noise.std()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("more", "verdict"), [(crosstalk, "unexplained"), (slow_noise, "nothing_detectable")]
)
def test_a_part_of_another_torque_is_told_from_slow_noise(more, verdict):
    logs = [made(arm(), seed, plain, 20.0) for seed in range(2)]
    for seed, log in enumerate(logs):
        log.frame["joint3.tau"] += more(log, seed)
    found = concluded(searched(arm(), logs[:1], never), never, logs[1:])
    assert found.verdict == verdict, found.sentence
    assert "joint3" in found.sentence  # of noise: they do not tell it
