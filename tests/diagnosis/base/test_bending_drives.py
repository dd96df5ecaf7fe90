"""A drive that bends, seen by its motor alone: Pinocchio's torques, a spring as Spong (1987) models it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.interpolate import CubicSpline
from six_axis_logs import COULOMB, ROTOR, VISCOUS, arm
from studies.rigid_arm.arm import Motion, moved, recorded, torque_noise

from flexmodels.files.robot_file import load_robot
from pyident.diagnosis.base.candidates import drive
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.drives import bending
from pyident.diagnosis.drives.bending import about_bends
from pyident.diagnosis.drives.springs import Fit, sought
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.search.measured import worth_name
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.regression.loads.swinging_drive import Spring

PACE = 4.0


def slow(springs: dict[int, float]):
    return pytest.param(springs, marks=pytest.mark.slow)


def at_motors(link: Motion, compliance: np.ndarray) -> Motion:
    """The motors' motion that moves the links so: each leads its link by compliance (6,) times the load."""
    load = CubicSpline(link.time, link.load)
    q, v, a = (own + compliance * load(link.time, i) for i, own in enumerate((link.q, link.v, link.a)))
    return replace(link, q=q, v=v, a=a)


def logged(seed: int, compliance: dict[int, float]) -> Log:
    rng = np.random.default_rng(seed)
    springs = np.array([compliance.get(k, 0.0) for k in range(1, 7)])
    motion = at_motors(moved(arm(), rng, 20.0, PACE), springs)
    tau = motion.load + ROTOR * motion.a + COULOMB * np.sign(motion.v) + VISCOUS * motion.v
    return recorded(motion, tau, torque_noise(tau), rng, f"log {seed}")


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def diagnosed(compliance: dict[int, float]) -> Diagnosis:
    logs = [logged(seed, compliance) for seed in range(3)]
    return concluded(searched(arm(), logs[:2], never), never, logs[2:])


@pytest.mark.slow
@pytest.mark.parametrize("springs", [slow({2: 2e-4}), slow({3: 1e-3}), {2: 3e-4, 3: 6e-4}])
def test_the_drive_and_its_compliance_are_named(springs):
    found = diagnosed(springs)
    named = {int(f.tie[0].joint[-1]): f.tie[0] for f in found.findings}
    assert {n.effect for n in named.values()} == {"drive_compliance"}
    assert set(named) == set(springs)
    for k, n in named.items():
        assert n.values["correction"] == pytest.approx(springs[k], rel=0.2)
        assert n.units["correction"] == "rad/(N m)"
        assert f"that joint{k} is rigid: its drive bends" in found.sentence
        assert any(
            note.startswith(f"drive_compliance at joint{k}: log where the link is") for note in found.notes
        )


def belt(seed: int, compliance: float) -> Log:
    """A slider of 80 kg behind a belt, its motor of 20 kg, in closed form: eight sines up to 4 Hz."""
    rng, t = np.random.default_rng(seed), np.arange(0, 20, 0.004)
    rates = np.zeros((5, len(t)))
    for frequency, size in zip(rng.uniform(0.3, 4.0, 8), rng.uniform(0.5, 1, 8), strict=True):
        w, phase = 2 * np.pi * frequency, rng.uniform(0, 2 * np.pi)
        rates += [0.05 * size * w ** (i - 1) * np.cos(w * t + phase + i * np.pi / 2) for i in range(5)]
    e, de, dde = rates[:3] + compliance * 80 * rates[2:]
    tau = 80 * rates[2] + 20 * dde + 20 * np.sign(de) + 200 * de + rng.normal(0, 0.3, len(t))
    frame = {"time": t, "joint1.e": e + rng.normal(0, 1e-7, len(t)), "joint1.tau": tau}
    return Log(pd.DataFrame(frame), f"log {seed}")


@pytest.mark.parametrize("compliance", [0.0, 1e-6])
def test_a_belt_is_named_without_its_size(compliance):
    logs = [belt(seed, compliance) for seed in range(3)]
    found = concluded(searched(load_robot("emps"), logs[:2], never), never, logs[2:])
    wrong = "Wrong: that joint1 is rigid: its belt or spindle stretches (100 %"
    assert found.sentence.startswith(wrong if compliance else "Nothing is missing")


@pytest.mark.slow
@pytest.mark.parametrize(("compliance", "named"), [(1e-4, True), (1e-7, False)])
def test_a_drive_that_hardly_gives_way_is_worth_no_name(compliance, named):
    search = searched(arm(), [logged(0, {})], never)
    assert worth_name(search, drive(2), np.array([compliance])) is named


def test_rigid_drives_are_not_said_to_bend():
    assert diagnosed({}).verdict == "nothing_detectable"


@pytest.mark.slow
@pytest.mark.parametrize("springs", [slow({2: 5e-4}), {2: 1.2e-3}])
def test_compliances_of_large_bends_are_those_of_the_springs(springs):
    """Links sag by up to two degrees, and bodies that are fitted without that are far from the arm's."""
    search = searched(arm(), [logged(0, springs)], never)
    bent = about_bends(search.resting_on(()))
    assert bent is not None
    bends = bent.examination.setting.bends
    compliances = {k: spring.compliance for k, spring in bends.items()}
    assert compliances == {k: pytest.approx(c, rel=0.1) for k, c in springs.items()}


def test_drives_that_tell_nearly_as_much_are_fitted_before_one_is_taken(monkeypatch):
    """Of an arm whose second drive bends the third's own equation had told most, and it got the name."""
    scanned, fitted = {1: 40.0, 2: 90.0, 3: 100.0}, {2: 200.0, 3: 110.0}
    fit = Fit(arm(), {}, 0.0)

    def told(_, fit, k):
        return replace(fit, drives={k: Spring(1e-5, 0.1)}, energy=scanned[k])

    def settled(_, begun, __):
        (joint,) = begun.drives  # of the first it would fail
        return replace(begun, energy=fitted[joint])

    monkeypatch.setattr(bending, "_with_sag", lambda _, fit, k: replace(fit, drives={3: None}))
    monkeypatch.setattr(bending, "_scanned", told)
    monkeypatch.setattr(bending, "_whitened", lambda search: search)
    monkeypatch.setattr(bending, "settled", settled)
    monkeypatch.setattr(
        bending, "_unless_much_more", lambda _, sag, swings: max(swings, key=lambda f: f.energy)
    )
    search: Any = None
    assert list(bending._further(search, fit, [1, 2, 3]).drives) == [2]


def test_a_spring_that_pushes_is_not_looked_about():
    nothing: Any = None
    fit = Fit(arm(), {2: Spring(-1e-6, 0.1)}, 0.0)
    assert sought(nothing, fit) is fit
