"""A hinge that nobody logs, found by what its motor feels: a pendulum on a spring, integrated by SciPy."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import pyident as pi
from flexmodels.files.robot_file import load_robot
from pyident.diagnosis.drives import unseen as unseen_drives
from pyident.diagnosis.drives.unseen import UnseenDrives, found, stated, unseen
from pyident.estimation.lock_unlogged import locked
from pyident.logs.log import Log
from pyident.regression.loads.swinging_drive import Spring

MASS, ARM, INERTIA, ROTOR = 10.0, 0.4, 2.1, 3.0  # kg, m, kg m2 about the joint
K, D = 5300.0, 6.3  # the link swings at 8 Hz
COULOMB, VISCOUS = 5.0, 8.0
FILE = """
name = "pendulum"
gravity = [0.0, 0.0, -9.81]
tip = [0.0, 0.0, -0.8]

[[joint]]
origin = [0.0, 0.0, 1.0]
x = [0.0, 1.0, 0.0]
y = [1.0, 0.0, 0.0]
J_m = 2.4
coulomb = 6.0
viscous = 7.0
k = [4200.0]
d = [8.0]

[[link]]
m = 12.0
com = [0.0, 0.0, -0.45]
J_com = [0.5, 0.6, 0.2]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "pendulum.toml"
    path.write_text(FILE)
    return path


@cache
def logged(seed: int, bends: bool = True, ripple: float = 0.0) -> Log:
    """Its motor goes by sines up to 12 Hz; what the link began with has died down when the log begins."""
    rng, time = np.random.default_rng(seed), np.arange(0, 20, 0.004)
    w = 2 * np.pi * np.geomspace(0.35, 12, 25)
    size, phase = 0.4 * (w[0] / w) ** 2, rng.uniform(0, 2 * np.pi, 25)

    def motor(t, order=0):
        return (size * w**order) @ np.sin(np.multiply.outer(w, t) + (phase + order * np.pi / 2)[:, None])

    e, speed, pull = motor(time), motor(time, 1), MASS * 9.81 * ARM
    carried = INERTIA * motor(time, 2) + pull * np.sin(e)
    if bends:
        course = CubicSpline(fine := np.arange(-6, 20.01, 5e-4), np.array([motor(fine), motor(fine, 1)]).T)

        def rate(t, x):
            q, v = course(t)
            return [x[1], (K * (q - x[0]) + D * (v - x[1]) - pull * math.sin(x[0])) / INERTIA]

        found = solve_ivp(rate, (-6, 20), course(-6), t_eval=time, rtol=1e-7, atol=1e-9, method="DOP853")
        carried = K * (e - found.y[0]) + D * (speed - found.y[1])
    tau = (
        ROTOR * motor(time, 2)
        + COULOMB * np.sign(speed)
        + VISCOUS * speed
        + ripple * np.sin(40 * e)
        + carried
    )
    frame = {"joint1.e": e + rng.normal(0, 1e-6, len(e)), "joint1.tau": tau + rng.normal(0, 0.2, len(e))}
    return Log(pd.DataFrame({"time": time, **frame}), f"log {seed}")


def test_stiffness_damping_and_rotor_are_those_of_the_machine(file):
    whole, logs = load_robot(file), [logged(0), logged(1)]
    rigid, _ = locked(whole, logs)
    assert unseen(whole, rigid) == [1]
    drives = found(whole, rigid, logs)
    assert drives is not None
    told = drives.hinges(logs[0])[1]
    assert told["k[1]"] == pytest.approx(K, rel=0.02)
    assert told["d[1]"] == pytest.approx(D, rel=0.2)
    assert told["J_m"] == pytest.approx(ROTOR, rel=0.03)


@pytest.mark.parametrize("of_file", [1700.0, 2600.0, 15000.0])
def test_what_the_file_says_of_the_stiffness_is_where_it_begins_alone(tmp_path, of_file):
    """A third of the truth to three times it: other starts end elsewhere, and leave more."""
    path = tmp_path / "off.toml"
    path.write_text(FILE.replace("4200.0", str(of_file)))
    whole, logs = load_robot(path), [logged(0)]
    drives = found(whole, locked(whole, logs)[0], logs)
    assert drives is not None
    told = drives.hinges(logs[0])[1]
    assert told["k[1]"] == pytest.approx(K, rel=0.03)
    assert told["J_m"] == pytest.approx(ROTOR, rel=0.05)


@pytest.mark.parametrize(("lefts", "stiffness"), [((1.0, 1.0, 1.0), None), ((1.0, 0.5, 1.0), 0.6 * 4200.0)])
def test_springs_that_other_ones_leave_as_little_as_are_not_told(file, monkeypatch, lefts, stiffness):
    """The best of those that end apart is told only if it leaves less."""
    whole, logs = load_robot(file), [logged(0)]
    rigid, _ = locked(whole, logs)
    begun = dict(zip((1.0, 0.6, 3.0), lefts, strict=True))

    def as_begun(whole, **_):
        k = whole.parameters["joint1.k[1]"]
        return UnseenDrives(rigid, {1: Spring(1 / k, 0.1, 3.0)}), begun[round(k / 4200.0, 3)]

    monkeypatch.setattr(unseen_drives, "_STARTS", tuple(begun))
    monkeypatch.setattr(unseen_drives, "_told", as_begun)
    drives = found(whole, rigid, logs)
    assert (drives is None) == (stiffness is None)
    if drives is not None:
        assert 1 / drives.springs[1].compliance == pytest.approx(stiffness)


def test_a_spring_that_is_damped_as_no_drive_is_not_told(file, monkeypatch):
    """Half of the critical damping: it takes what something else leaves."""
    whole, logs = load_robot(file), [logged(0)]
    rigid, _ = locked(whole, logs)
    assert found(whole, rigid, logs) is not None
    monkeypatch.setattr(unseen_drives, "_GEARS", 1e-3)
    assert found(whole, rigid, logs) is None


LOOP = """
[controller]
rate = 250.0
Kp = [9000.0]
Kd = [300.0]
Ki = [0.0]
"""


def test_a_loop_that_is_known_is_not_simulated_with_rigid_drives(tmp_path):
    """Its floors and instruments would be another machine's; what is written keeps the controller."""
    path = tmp_path / "held.toml"
    path.write_text(FILE.replace("[[joint]]", LOOP + "[[joint]]", 1))
    logs = [logged(0), logged(1)]
    fit = pi.identify(path, logs)
    assert fit.robot.controller is not None
    assert any("the [controller] is not used" in note for note in fit.notes)
    assert fit.robot.parameters["joint1.k[1]"] == pytest.approx(K, rel=0.02)
    found = pi.diagnose(path, logs, heldout=logged(2))
    assert found.to_dict()["verdict"] == "nothing_detectable"
    added = pi.add_effect(path, "torque_ripple", 1, logs, heldout=logged(2))
    assert not added.accepted
    assert added.robot.controller is not None


def test_the_identified_model_has_its_hinge_and_the_error_falls_to_the_noise(file, tmp_path):
    fit = pi.identify(file, [logged(0), logged(1)], heldout=logged(2))
    values = fit.robot.parameters
    assert values["joint1.k[1]"] == pytest.approx(K, rel=0.02)
    assert values["joint1.J_m"] == pytest.approx(ROTOR, rel=0.03)
    assert fit.to_dict()["parameters"]["joint1.k[1]"]["value"] == values["joint1.k[1]"]
    assert any("k[1] = " in note for note in fit.notes)
    assert not any("samples early" in note for note in fit.notes)  # a link that swings looks so
    (left,) = fit.heldout.values()
    assert left["all"] < 1.0  # %, of noise 0.4; rigid drives leave 66
    again = load_robot(fit.save(tmp_path / "identified.toml"))
    log = logged(2)
    rigid, _ = locked(again, [log])
    drives = stated(again, rigid, log)
    assert drives is not None
    assert np.std(drives.rigid(log).frame["joint1.tau"] - log.frame["joint1.tau"]) > 1.0


@pytest.mark.parametrize(("ripple", "verdict"), [(0.0, "nothing_detectable"), (1.5, "missing_effect")])
def test_what_else_a_model_lacks_is_found_beside_springs(file, ripple, verdict):
    logs = [logged(seed, ripple=ripple) for seed in range(2)]
    diagnosis = pi.diagnose(file, logs, heldout=logged(2, ripple=ripple))
    assert diagnosis.to_dict()["verdict"] == verdict
    if ripple:
        assert diagnosis.to_dict()["findings"][0]["tie"][0]["effect"] == "torque_ripple"


def test_a_drive_that_hardly_bends_stays_locked(file):
    whole, logs = load_robot(file), [logged(0, bends=False)]
    rigid, notes = locked(whole, logs)
    drives = found(whole, rigid, logs)
    assert drives is None
    assert len(notes) == 1


def test_a_law_is_added_and_the_written_model_keeps_its_hinge(file, tmp_path):
    logs = [logged(seed, ripple=1.5) for seed in range(2)]
    added = pi.add_effect(file, "torque_ripple", 1, logs, heldout=logged(2, ripple=1.5))
    assert added.accepted
    again = load_robot(added.save(tmp_path / "better.toml")).parameters
    assert again["joint1.k[1]"] == pytest.approx(K, rel=0.02)
    assert again["joint1.J_m"] == pytest.approx(ROTOR, rel=0.05)
    ripple = np.hypot(again["joint1.torque_ripple.sine"], again["joint1.torque_ripple.cosine"])
    assert ripple == pytest.approx(1.5, rel=0.1)
