"""Wind on an axis whose controller answers it; and a drive that delivers late, in the same motion."""

import numpy as np
import pandas as pd
import pytest

import pyident as pi
from flexmodels.files.robot_file import load_robot
from pyident.diagnosis.imitators.answer import answers
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import runs_here

J, VISCOUS, WIND, LATE = 900.0, 300.0, 60.0, 0.02  # kg m2, N m s, N m, s
ROBOT = """
name = "mount"
gravity = [0.0, 0.0, -9.81]
[[joint]]
origin = [0.0, 0.0, 1.0]
x = [0.0, 0.0, 1.0]
y = [1.0, 0.0, 0.0]
J_m = 100.0
viscous = 0.0
offset = 0.0
[[link]]
m = 800.0
com = [0.0, 0.0, 0.5]
J_com = [500.0, 500.0, 500.0]
"""


def logged(seed, wind=0.0, late=0.0):
    """40 s at 100 Hz of a loop of 1 kHz; the gusts last 0.8 s."""
    rng, period = np.random.default_rng(seed), 1e-3
    time = np.arange(0, 40, period)
    rates = 2 * np.pi * rng.uniform(0.1, 0.7, 4)
    reference = 0.2 * np.sin(np.outer(time, rates) + rng.uniform(0, 6, 4)).sum(axis=1)
    stay, w = np.exp(-period / 0.8), 2 * np.pi * 3
    e, de, gust, integral, delivered = reference[0], 0.0, 0.0, 0.0, 0.0
    rows = []
    for r, push in zip(reference, rng.normal(0, np.sqrt(1 - stay**2), len(time)), strict=True):
        gust = stay * gust + push
        integral += (r - e) * period
        tau = J * (w**2 * (r - e) - 1.4 * w * de + w**3 / 5 * integral)
        delivered += (tau - delivered) * (period / late if late else 1.0)
        rows.append((r, e, tau))
        de += (delivered + wind * gust - VISCOUS * de) / J * period
        e += de * period
    r, e, tau = np.transpose(rows[::10])
    count = 2 * np.pi / 2**24
    tau = tau + rng.normal(0, 6.0, len(tau))
    return pd.DataFrame(
        {"time": time[::10], "joint1.r": r, "joint1.e": count * np.round(e / count), "joint1.tau": tau}
    )


@pytest.fixture(scope="module")
def mount(tmp_path_factory):
    path = tmp_path_factory.mktemp("mount") / "mount.toml"
    path.write_text(ROBOT)
    return load_robot(path)


def late_torque_in(mount, **what):
    """A search that rests on a late torque; and that torque."""
    logs = [Log(logged(seed, **what), f"log {seed}") for seed in (0, 1)]
    search = searched(mount, logs, runs_here)
    late = search.best("torque_delay", 1)
    assert late is not None
    return search.with_further([late.candidate]), late.candidate


def test_the_answer_to_wind_is_no_late_torque(mount):
    assert answers(*late_torque_in(mount, wind=WIND))


def test_a_late_torque_is_no_answer(mount):
    assert not answers(*late_torque_in(mount, late=LATE))


def test_a_late_torque_is_named(mount):
    logs = [logged(seed, late=LATE) for seed in range(3)]
    found = pi.diagnose(mount, logs[:2], heldout=logs[2]).diagnosis
    assert "torque_delay" in {c.effect for c in found.findings[0].tie}
