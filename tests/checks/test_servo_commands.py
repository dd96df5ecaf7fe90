"""Commands that a servo's positions do not follow are refused; soft loops, weights and rest are not."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter
from servo_pendulum import pendulum

import pyident as pi

TIME = 0.01 * np.arange(1500)
COMMAND = 0.7 * np.sin(2.1 * TIME) + 0.4 * np.sin(5.3 * TIME + 1.0)
FOLLOWED = np.asarray(lfilter([0.15], [1, -0.85], COMMAND))  # late by some 60 ms


def _kinds(command: np.ndarray, position: np.ndarray, **more: np.ndarray) -> set[tuple[str, str]]:
    columns = {"time": TIME, "joint1.r": command, "joint1.e": position} | {
        name.replace("_", "."): values for name, values in more.items()
    }
    found = pi.check_log(pendulum(), pd.DataFrame(columns))
    return {(d.severity, d.kind) for d in found}


@pytest.mark.parametrize("gain", [1.0, 0.3, 0.1])
def test_a_servo_that_follows_as_far_as_its_gain_reaches_is_sound(gain):
    assert not _kinds(COMMAND, gain * FOLLOWED)


def test_steps_and_a_slow_answer_are_sound():
    steps = np.repeat(np.random.default_rng(1).uniform(-1, 1, 15), 100)
    assert not _kinds(steps, np.asarray(lfilter([0.03], [1, -0.97], steps)))


@pytest.mark.parametrize(
    ("command", "position", "kind"),
    [
        (FOLLOWED, COMMAND, "command"),
        (COMMAND, -FOLLOWED, "sign"),
        (np.full(1500, 0.2), FOLLOWED, "constant"),
        (COMMAND, np.degrees(FOLLOWED), "unit"),
    ],
)
def test_what_no_servo_does_is_refused(command, position, kind):
    assert ("gross", kind) in _kinds(command, position)


def test_zeros_far_apart_are_doubted():
    assert ("doubtful", "zero") in _kinds(COMMAND, FOLLOWED + 9.0)


def test_a_servo_that_is_off_need_not_follow():
    off = np.zeros(1500)
    assert not _kinds(np.full(1500, 0.2), FOLLOWED, joint1_on=off)
