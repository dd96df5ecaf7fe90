"""An arm whose joint shakes the other one, in closed loop: by dry friction as it turns round, or by a ripple.

Two links in a vertical plane, in closed form, in steps of 0.1 ms; nothing here knows the project's laws.
"""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import pyident as pi
from flexmodels.files.robot_file import load_robot
from pyident.diagnosis.base.projection import extended
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.denoised import denoised_every_sample

STEP, LOOP, LOGGED = 1e-4, 1e-3, 8e-3  # s
# Inertias [kg m2] with the motors', the links' pull [N m] and their friction.
A1, A2, A3 = 4.2, 0.6, 0.9
PULL1, PULL2 = 45.0, 12.0
COULOMB, VISCOUS = (20.0, 3.0), (9.0, 2.0)
FILE = (
    """
name = "two"
gravity = [0.0, 0.0, -9.81]
tip = [0.0, 0.0, -0.4]
"""
    + "".join(
        f"""
[[joint]]
origin = [0.0, 0.0, {z}]
x = [0.0, 1.0, 0.0]
y = [1.0, 0.0, 0.0]
J_m = 0.3
coulomb = 5.0
viscous = 3.0
"""
        for z in (1.0, -0.5)
    )
    + "".join(
        """
[[link]]
m = 5.0
com = [0.0, 0.0, -0.2]
J_com = [0.1, 0.1, 0.02]
"""
        for _ in range(2)
    )
)


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "two.toml"
    path.write_text(FILE)
    return path


@cache
def logged(seed: int, ripple: float = 0.0, load: float = 0.0, duration: float = 24.0) -> Log:
    """ripple [N m], 150 times a turn of joint 1;  load: friction of joint 1 per torque of its links."""
    rng, count = np.random.default_rng(seed), round(LOGGED / LOOP)
    w = 2 * np.pi * np.array([0.11, 0.23, 0.37, 0.52])
    size, phase = np.array([0.5, 0.3, 0.15, 0.08]), rng.uniform(0, 2 * np.pi, (2, 4))

    def wanted(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x = w * t + phase
        return np.sin(x) @ size, np.cos(x) @ (size * w), -np.sin(x) @ (size * w * w)

    q, v = wanted(0.0)[0].tolist(), wanted(0.0)[1].tolist()
    rows = []
    for number in range(round(duration / LOOP)):
        r, dr, ddr = wanted(number * LOOP)
        tau = [
            J * a + K * (x - y) + D * (dx - dy)
            for J, K, D, a, x, y, dx, dy in zip(
                (5.4, 0.9), (4000.0, 900.0), (220.0, 45.0), ddr, r, q, dr, v, strict=True
            )
        ]
        if number % count == 0:
            rows.append((number * LOOP, *q, *tau))
        for _ in range(round(LOOP / STEP)):
            c, s, g2 = math.cos(q[1]), math.sin(q[1]), PULL2 * math.sin(q[0] + q[1])
            M11, M12 = A1 + A3 + 2 * A2 * c, A3 + A2 * c
            h1 = -A2 * s * v[1] * (2 * v[0] + v[1]) + PULL1 * math.sin(q[0]) + g2
            h2 = A2 * s * v[0] ** 2 + g2
            f1 = (COULOMB[0] + load * abs(h1)) * math.tanh(v[0] / 2e-3) + VISCOUS[0] * v[0]
            f1 += ripple * math.sin(150 * q[0])
            f2 = COULOMB[1] * math.tanh(v[1] / 2e-3) + VISCOUS[1] * v[1]
            b1, b2, det = tau[0] - h1 - f1, tau[1] - h2 - f2, M11 * A3 - M12**2
            v[0] += STEP * (A3 * b1 - M12 * b2) / det
            v[1] += STEP * (M11 * b2 - M12 * b1) / det
            q[0] += STEP * v[0]
            q[1] += STEP * v[1]
    x = np.array(rows)
    x[:, 1:3] += rng.normal(0, 2e-6, (len(x), 2))
    x[:, 3:] += rng.normal(0, 0.003, (len(x), 2)) * x[:, 3:].std(axis=0)
    names = ["time", "joint1.e", "joint2.e", "joint1.tau", "joint2.tau"]
    return Log(pd.DataFrame(dict(zip(names, x.T, strict=True))), f"log {seed}")


def test_where_one_turns_round_the_other_tells_nothing(file):
    log, robot = logged(0), load_robot(file)
    part = denoised_every_sample(robot, log)
    turns = np.flatnonzero(np.diff(np.sign(part.motion.dq[:, 0])))
    beside = [(part.use[turn - 15 : turn + 15, 1] == 0).any() for turn in turns if turn > 100]
    assert np.mean(beside) > 0.9
    assert (part.use[:, 1] > 0).mean() > 0.6


def test_a_heavy_friction_of_one_joint_is_nothing_at_the_other(file):
    found = pi.diagnose(file, [logged(0), logged(1)], heldout=logged(2)).diagnosis
    assert found.verdict == "nothing_detectable", found.sentence


def test_a_ripple_that_shakes_the_arm_is_one_effect(file):
    logs = [logged(seed, ripple=4.0) for seed in range(3)]
    found = pi.diagnose(file, logs[:2], heldout=logs[2]).diagnosis
    assert [f.tie[0].effect for f in found.findings] == ["torque_ripple"], found.sentence
    assert found.findings[0].tie[0].joint == "joint1"
    assert not any(place.state == "unexplained" for place in found.places), found.sentence


def test_what_a_ripple_does_to_the_other_joint_is_taken_with_it(file):
    search = searched(load_robot(file), [logged(seed, ripple=4.0) for seed in range(2)], never)
    ripple = search.best("torque_ripple", 1, answered=True)
    assert ripple is not None
    alone = replace(search, base=extended(search.base, search.columns(ripple.candidate)))
    taken = search.resting_on([ripple.candidate])
    assert taken.remaining_on([1]) < 0.5 * alone.remaining_on([1])
    assert taken.remaining_on([0]) == pytest.approx(alone.remaining_on([0]), rel=0.05, abs=5)
