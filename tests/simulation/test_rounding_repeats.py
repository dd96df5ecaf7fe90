"""What a loop makes of its encoder's rounding: closed forms, and the floor of a motion that repeats."""

import numpy as np
import pandas as pd
import pytest

from flexmodels.files.robot_file import load_robot
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.noise.rounding import Rounding

PERIOD, COUNT = 0.01, 6000
SIZE, RATE = 4000.0, 300.0  # gains of a controller


def of(spectrum, lowest, highest):
    """Mean density between two frequencies [Hz]."""
    inside = (spectrum.frequencies >= lowest) & (spectrum.frequencies < highest)
    return spectrum.density[inside].mean()


def test_the_answer_to_rounding_is_known_where_no_motion_shows_it():
    """Below 5 Hz the low pass has left none of the rounding; the torque has noise of its own beside."""
    rng = np.random.default_rng(0)
    noise = 1e-4 * rng.standard_normal(COUNT)
    f = np.fft.rfftfreq(COUNT, PERIOD)
    read = np.fft.rfft(noise)
    torque = -np.fft.irfft((SIZE + 2j * np.pi * f * RATE) * read, COUNT) + 0.5 * rng.standard_normal(COUNT)
    beside = np.fft.irfft(read * (f > 5), COUNT)
    found = Rounding.of(np.column_stack([beside, np.zeros(COUNT)]), 15.0, PERIOD)
    assert found is not None
    for low, high in ((1, 2), (2, 5), (8, 12)):
        g = np.linspace(low, high, 50)
        true = np.mean(np.abs(SIZE + 2j * np.pi * g * RATE) ** 2) * 2 * 1e-8 * PERIOD
        assert of(found.answer(torque), low, high) == pytest.approx(true, rel=0.25)
    assert of(found.answer(torque), 20, 40) == 0.0  # there it is measured


def test_a_shaking_is_what_stands_clear_of_white_noise():
    rng = np.random.default_rng(1)
    time = np.arange(COUNT) * PERIOD
    shaking = 1e-3 * np.sin(2 * np.pi * 9 * time)
    beside = shaking + 1e-4 * rng.standard_normal(COUNT)
    found = Rounding.of(beside[:, None], 20.0, PERIOD)
    assert found is not None
    true = -((2 * np.pi * 9) ** 2) * shaking
    left = (found.shaken[:, 0] - true)[200:-200]
    assert np.std(left) < 0.1 * np.std(true)


def test_without_rounding_or_without_quiet_frequencies_nothing_is_said():
    assert Rounding.of(np.zeros((COUNT, 2)), 15.0, PERIOD) is None
    assert Rounding.of(np.ones((COUNT, 2)), 60.0, PERIOD) is None


def carriage(seed, step, size, rate, inner=20):
    """A log of a carriage with dry friction under a loop that reads it rounded; its motion repeats."""
    mass, viscous, coulomb, h = 95.0, 200.0, 20.0, PERIOD / inner
    time = np.arange(4000) * PERIOD
    turns = 2 * np.pi * 0.1 * time
    wanted = 0.1 * np.sin(turns) + 0.03 * np.cos((3 + seed) * turns) + 0.01 * np.sin((7 - seed) * turns)
    speed = np.gradient(wanted, PERIOD)
    x, v, before, read, torque = wanted[0], speed[0], wanted[0], [], []
    for position, rate_wanted in zip(wanted, speed, strict=True):
        now = step * np.round(x / step)
        force = size * (position - now) + rate * (rate_wanted - (now - before) / PERIOD)
        before = now
        read.append(now)
        torque.append(force)
        for _ in range(inner):
            free = v + h * (force - viscous * v) / mass
            v = np.sign(free) * max(abs(free) - h * coulomb / mass, 0.0)
            x += h * v
    noisy = np.array(torque) + 0.3 * np.random.default_rng(seed).standard_normal(len(torque))
    return Log.from_frame(pd.DataFrame({"time": time, "joint1.e": read, "joint1.tau": noisy}), f"log {seed}")


def never(_):
    raise AssertionError("nothing is simulated where the loop is unknown")


@pytest.mark.parametrize(("step", "size", "rate"), [(2e-4, 6e4, 1500.0), (5e-5, 2e5, 2500.0)])
def test_rounding_that_repeats_with_the_motion_is_nothing_that_is_missing(step, size, rate):
    """By what the periods differ in alone, both are `unexplained`."""
    logs = [carriage(seed, step, size, rate) for seed in range(2)]
    found = concluded(searched(load_robot("emps"), logs[:1], never), never, logs[1:])
    assert found.verdict == "nothing_detectable", found.sentence
