"""A simulation's log as the sensors of the measured one would show it."""

import numpy as np
import pandas as pd
import pytest

from pyident.simulation.noise.noise_spectrum import NoiseSpectrum
from pyident.simulation.sensors import Sensors

MOTOR, LINK, PERIOD = 4e-5, 6e-6, 0.001
TIME = PERIOD * np.arange(8000)
TWIST = "joint1.eps[1]"
FRAME = pd.DataFrame(
    {
        "time": TIME,
        "joint1.e": np.sin(TIME),
        TWIST: 1e-3 * np.cos(TIME),
        "joint1.tau": 5 * np.sin(3 * TIME),
        "tip.x": np.zeros(len(TIME)),
    }
)


def read(seconds, held=False, seed=1, noise=None):
    steps = {"joint1.e": MOTOR, TWIST: LINK, "joint1.tau": 0.0}
    torques = {"joint1.tau": NoiseSpectrum.white(0.1, PERIOD)}
    sensors = Sensors(("joint1.e", TWIST), steps, torques, seconds, held)
    return sensors.read(FRAME, noise or {}, seed)


def steps_of(x: np.ndarray, step: float) -> np.ndarray:
    """How far samples are from whole steps beyond the first."""
    ratio = (x - x[0]) / step
    return np.abs(ratio - np.round(ratio)).max()


def test_positions_are_rounded_to_steps_that_begin_anywhere():
    one, other = (read({}, seed=seed)["joint1.e"].to_numpy() for seed in (1, 2))
    for x in (one, other):
        assert steps_of(x, MOTOR) < 1e-6
        assert np.abs(x - FRAME["joint1.e"]).max() <= MOTOR / 2 * (1 + 1e-9)
    assert steps_of(np.append(one[:1], other), MOTOR) > 0.01


def test_a_twist_of_two_encoders_holds_the_rounding_of_both():
    found = read({TWIST: "joint1.e"})
    link = (found["joint1.e"] + found[TWIST]).to_numpy()
    assert steps_of(link, LINK) < 1e-6
    twist, motor = (found[name].to_numpy() - FRAME[name].to_numpy() for name in (TWIST, "joint1.e"))
    assert np.std(twist) == pytest.approx(np.hypot(MOTOR, LINK) / np.sqrt(12), rel=0.05)
    assert np.corrcoef(twist, motor)[0, 1] < -0.95


def test_noise_beyond_rounding_is_added():
    found = read({}, noise={"joint1.e": MOTOR})["joint1.e"].to_numpy()
    assert np.std(found - FRAME["joint1.e"].to_numpy()) == pytest.approx(MOTOR, rel=0.05)


@pytest.mark.parametrize(("held", "behind"), [(True, 0.0), (False, PERIOD / 2)])
def test_a_torque_is_noisy_and_as_late_as_the_equations_take_it(held, behind):
    error = read({}, held=held)["joint1.tau"].to_numpy() - 5 * np.sin(3 * (TIME - behind))
    assert np.std(error) == pytest.approx(0.1, rel=0.05)
    assert abs(error[3:] @ np.cos(3 * TIME[3:])) / len(TIME) < 0.003


def test_a_tip_is_read_with_its_noise():
    assert np.std(read({}, noise={"tip.x": 0.2})["tip.x"].to_numpy()) == pytest.approx(0.2, rel=0.05)
