"""A joint that bends under a loop that nobody knows, by a simulation of its own: torques are held from their
sample on, encoders have steps, and the torque's noise is slow."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter

import pyident as pi
from flexmodels.files.robot_file import load_robot
from pyident.logs.log import Log
from pyident.simulation.sensors import sensors_of
from pyident.simulation.stabilising import stabilising_controller

PERIOD, SUBSTEPS, SECONDS = 0.002, 10, 16.0
MOTOR, LINK, STIFFNESS, DAMPING, VISCOUS, COULOMB = 0.02, 0.03, 300.0, 0.25, 0.06, 0.35
ENCODERS = 2 * np.pi / 2**17, 2 * np.pi / 2**20
NOISE, SLOW, CORNER = 0.01, 0.01, 0.15  # N m, N m, Hz
REST = 1e-3  # rad/s

ROBOT = """
name = "rig"
[[joint]]
x = [0.0, 0.0, 1.0]
y = [1.0, 0.0, 0.0]
J_m = 0.015
coulomb = 0.1
viscous = 0.1
k = [200.0]
d = [0.1]
[[link]]
m = 3.5
com = [0.05, 0.0, 0.02]
J_com = [0.01, 0.01, 0.02]
"""


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    file = tmp_path_factory.mktemp("rig") / "rig.toml"
    file.write_text(ROBOT, encoding="utf-8")
    return load_robot(str(file))


def simulated(seed: int, gap: float = 0.0) -> pd.DataFrame:
    """By Heun's method; gap: half of the play of the drive [rad]."""
    rng, count = np.random.default_rng(seed), round(SECONDS / PERIOD)
    time = PERIOD * np.arange(count)
    orders, phases = np.arange(1, 7), rng.uniform(0, 2 * np.pi, 6)
    reference = np.cos(2 * np.pi * (0.4 + 0.05 * seed) * np.outer(time, orders) + phases) @ (0.8 / orders)
    state, before = np.array([reference[0], reference[0], 0.0, 0.0]), reference[0]
    logged = np.empty((count, 3))

    def rates(x: np.ndarray, torque: float) -> np.ndarray:
        twist = x[1] - x[0]
        spring = STIFFNESS * (twist - min(max(twist, -gap), gap)) + DAMPING * (x[3] - x[2])
        friction = COULOMB * np.tanh(x[2] / REST) + VISCOUS * x[2]
        return np.array([x[2], x[3], (torque - friction + spring) / MOTOR, -spring / LINK])

    for at in range(count):
        motor, link = (round(x / step) * step for x, step in zip(state[:2], ENCODERS, strict=True))
        speed, before = (motor - before) / PERIOD, motor
        torque = 40.0 * (reference[at] - motor) - 1.2 * speed
        logged[at] = motor, link - motor, torque
        step = PERIOD / SUBSTEPS
        for _ in range(SUBSTEPS):
            first = rates(state, torque)
            state = state + step / 2 * (first + rates(state + step * first, torque))
    pole = np.exp(-2 * np.pi * CORNER * PERIOD)
    slow = np.asarray(lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], rng.standard_normal(count)))
    logged[:, 2] += SLOW * slow + NOISE * rng.standard_normal(count)
    names = ("joint1.e", "joint1.eps[1]", "joint1.tau")
    return pd.DataFrame({"time": time, **dict(zip(names, logged.T, strict=True))})


@pytest.fixture(scope="module")
def logs():
    return [simulated(seed) for seed in (1, 2, 3)]


def test_the_torques_are_taken_as_held_and_the_parameters_are_the_rig_s(rig, logs):
    found = pi.identify(rig, logs[:2])
    assert any("held from their sample until the next" in note for note in found.notes)
    assert found.robot.settings.processing.derivative == "hat"
    values = found.robot.parameters
    for name, true in {"J_m": MOTOR, "k[1]": STIFFNESS, "d[1]": DAMPING, "coulomb": COULOMB}.items():
        assert values[f"joint1.{name}"] == pytest.approx(true, rel=0.02), name


def test_replicas_hold_their_torques_as_the_equations_take_them(rig, logs):
    """Under a controller that the file knows, too, where a log cannot be followed by it."""
    log = Log(logs[0], "rig")
    driven = replace(rig, controller=stabilising_controller(rig, log.signals(rig.coordinates), log.period))
    hat = rig.with_settings(processing=replace(rig.settings.processing, derivative="hat"))
    assert [sensors_of(robot, log).held for robot in (rig, hat, driven)] == [False, True, True]


def test_nothing_is_missing_and_slow_noise_is_said_to_be_all(rig, logs):
    found = pi.diagnose(rig, logs[:2], heldout=logs[2:]).diagnosis
    assert found.verdict == "nothing_detectable"
    assert "All torques are held from their sample on" in found.sentence
    assert {p.state for p in found.places} == {"in_order"}


@pytest.mark.slow
def test_a_gap_is_found_with_its_width(rig):
    logs = [simulated(seed, gap=6e-4) for seed in (1, 2, 3)]
    found = pi.diagnose(rig, logs[:2], heldout=logs[2:]).diagnosis
    (finding,) = found.findings
    assert (finding.tie[0].effect, finding.tie[0].joint) == ("backlash", "joint1")
    assert finding.tie[0].values["gap"] == pytest.approx(6e-4, rel=0.05)
