"""A joint that bends, with coarse encoders and no cutoff: made by flatness, from how its link moves."""

import numpy as np
import pandas as pd
import pytest

import pyident as pi

J, J_M, K, COULOMB, VISCOUS = 0.0044, 0.0021, 1.3, 0.03, 0.073
ROBOT = """
name = "one_spring"
gravity = [0.0, 0.0, -9.81]
[[joint]]
origin = [0.0, 0.0, 0.1]
x = [0.0, 0.0, 1.0]
y = [1.0, 0.0, 0.0]
J_m = 0.002
coulomb = 0.0
viscous = 0.0
k = [1.0]
d = [0.01]
[[link]]
m = 0.065
com = [0.14, 0.0, 0.0]
J_com = [1e-5, 2e-3, 2e-3]
"""


def sines(time, rng):
    """(7, N) an angle and its rates: five sines up to 2.5 Hz."""
    rates = np.zeros((7, len(time)))
    for w, phase in zip(2 * np.pi * rng.uniform(0.3, 2.5, 5), rng.uniform(0, 6, 5), strict=True):
        rates += [0.4 * w**i * np.sin(w * time + phase + i * np.pi / 2) for i in range(7)]
    return rates


def logged(seed, counts):
    rng, time = np.random.default_rng(seed), np.arange(0, 20, 0.002)
    link = sines(time, rng)
    bend = -J * link[2:] / K
    motor = link[:5] - bend[:5]
    tau = J_M * motor[2] + J * link[2] + COULOMB * np.sign(motor[1]) + VISCOUS * motor[1]
    step = 2 * np.pi / counts
    columns = {"joint1.e": motor[0], "joint1.eps[1]": bend[0]}
    rounded = {name: step * np.round(x / step) for name, x in columns.items()}
    tau = tau + rng.normal(0, 0.002, len(time))
    return pd.DataFrame({"time": time, **rounded, "joint1.tau": tau})


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    path = tmp_path_factory.mktemp("robot") / "one_spring.toml"
    path.write_text(ROBOT)
    return path


def test_the_spring_is_identified_from_coarse_encoders(robot):
    fit = pi.identify(robot, [logged(seed, 4096) for seed in range(2)])
    assert any("low pass of" in note for note in fit.notes)
    p = fit.robot.parameters
    assert p["joint1.k[1]"] == pytest.approx(K, rel=0.03)
    assert p["link1.J[zz]"] == pytest.approx(J, rel=0.03)
    assert p["joint1.J_m"] == pytest.approx(J_M, rel=0.2)


def test_nothing_is_missing_there(robot):
    logs = [logged(seed, 4096) for seed in range(3)]
    assert pi.diagnose(robot, logs[:2], heldout=logs[2]).verdict == "nothing_detectable"


def test_fine_encoders_pass_no_filter(robot):
    fit = pi.identify(robot, logged(0, 2**26))
    assert not any("low pass of" in note for note in fit.notes)
