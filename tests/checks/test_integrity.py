"""Every defect is put into a sound log and must be named; sound logs must pass."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodels.files.robot_file import load_robot
from pyident.checks.channels import integrity
from pyident.checks.timing_and_signs import SHIFTS, shifted
from pyident.logs.log import Log, read_log


@pytest.fixture(scope="module")
def sound(identification_log):
    """With a sensor's noise, so that no value repeats itself by computation alone."""
    rng, frame = np.random.default_rng(0), identification_log.frame.copy()
    for name in frame:
        if name.split(".")[-1].startswith(("e", "eps")):
            frame[name] += rng.normal(0, 2e-6 if name.endswith(".e") else 1e-6, len(frame))
    return Log(frame, "log.csv")


def changed(log: Log, **columns) -> Log:
    frame = log.frame.copy()
    for name, change in columns.items():
        name = name.replace("_", ".")
        frame[name] = change(frame[name].to_numpy(float).copy())
    return replace(log, frame=frame)


def with_jump(x):
    x[2000:] += 3e-3
    return x


def wrapped(x):
    x += 2.0
    return np.mod(x + np.pi, 2 * np.pi) - np.pi


def stuck(x):
    x[3000:3060] = x[3000]
    return x


def slowly(x):
    return np.repeat(x[::4], 4)[: len(x)]


def limited(x):
    return np.clip(x, *(0.6 * np.array([x.min(), x.max()])))


def test_sound_logs_have_no_defect(four_link, identification_log, sound):
    assert integrity(four_link, sound) == []
    assert integrity(four_link, identification_log) == []


def test_a_measured_log_has_no_defect(data):
    robot = load_robot("emps")
    assert integrity(robot, read_log(data / "emps/DATA_EMPS.mat", robot.columns)) == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"joint2_tau": limited}, "joint2.tau stands at"),
        ({"joint3_e": with_jump}, "joint3.e jumps by 0.003"),
        ({"joint1_e": wrapped}, "joint1.e jumps by a turn"),
        ({"joint2_e": stuck}, "joint2.e is stuck"),
        ({"joint4_eps[2]": lambda x: 0 * x}, "joint4.eps[2] is 0 throughout"),
        (
            {"joint1_tau": slowly},
            "joint1.tau changes only every 4th sample",
        ),
        ({"joint2_e": lambda x: np.round(x / 2e-3) * 2e-3}, "joint2.e comes in steps of 0.002"),
        ({"joint3_tau": lambda x: -x}, "joint3.tau has the wrong sign"),
        ({"joint2_e": lambda x: -x}, "joint2.tau has the wrong sign against joint2.e"),
        ({"joint1_eps[1]": lambda x: -x}, "joint1.eps[1] has the wrong sign"),
        ({"joint4_tau": lambda x: np.roll(x, 1)}, "joint4.tau is 1 samples (4 ms) late"),
        ({"joint2_tau": lambda x: np.roll(x, -2)}, "joint2.tau is 2 samples (8 ms) early"),
        ({"time": lambda t: t + 0.02 * np.sin(2 * np.pi * t / t[-1])}, "the clock drifts"),
    ],
)
def test_a_defect_is_named(four_link, sound, change, words):
    found = integrity(four_link, changed(sound, **change))
    assert any(words in sentence for sentence in found), found
    assert all(sentence.startswith("log.csv: ") for sentence in found)


def test_doubled_rows_are_named(four_link, sound):
    at = np.arange(len(sound))
    at[[500, 900, 1400, 2000]] -= 1
    frame = sound.frame.iloc[at].reset_index(drop=True)
    frame["time"] = sound.frame["time"]
    assert any("recorded twice" in s for s in integrity(four_link, replace(sound, frame=frame)))


@pytest.mark.parametrize("shift", [-1.0, 0.5])
def test_a_torque_between_samples_is_placed(four_link, sound, shift):
    """Half a sample late: the controller's torque as a mean over the sample before and after."""
    tau = sound.frame["joint3.tau"].to_numpy(float)
    spectrum = np.fft.rfft(tau) * np.exp(-2j * np.pi * np.fft.rfftfreq(len(tau)) * shift)
    moved = changed(sound, joint3_tau=lambda _: np.fft.irfft(spectrum, len(tau)))
    left = shifted(four_link, moved)
    assert SHIFTS[np.argmin(left[2])] == shift
    assert (SHIFTS[np.argmin(np.delete(left, 2, axis=0), axis=1)] == 0).all()
