"""Intervals where no loop is known and the noise of encoders, differenced, exceeds the torque."""

from dataclasses import replace

import numpy as np
import pytest
from studies.rigid_arm.arm import COULOMB, ROTOR, VISCOUS, arm, moved, recorded

import pyident as pi
from pyident.simulation.noise.sensor_noise import sensor_noise

ENCODER, TORQUE = 5e-5, 0.05  # rad, N m
LOGS = 4


@pytest.fixture(scope="module")
def logs():
    """Of one motion with the friction of the arm, each with noise of its own."""
    pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")
    robot, rng = arm(), np.random.default_rng(7)
    motion = moved(robot, rng, 12.0, 4.0)
    tau = motion.load + ROTOR * motion.a + COULOMB * np.sign(motion.v) + VISCOUS * motion.v
    made = []
    for number in range(LOGS):
        log = recorded(motion, tau, np.full(6, TORQUE), rng, f"log {number}")
        frame = log.frame.copy()
        for k in range(1, 7):
            frame[f"joint{k}.e"] += ENCODER * rng.standard_normal(len(frame))
        made.append(replace(log, frame=frame))
    return made


def truth(name: str) -> float:
    of = {"coulomb": COULOMB, "viscous": VISCOUS, "J_m": ROTOR, "offset": np.zeros(6)}
    joint, _, quantity = name.partition(".")
    return float(of[quantity][int(joint.removeprefix("joint")) - 1])


def test_the_noise_of_torques_is_not_that_of_the_encoders(logs):
    """Its power is hidden at high frequencies, and bounded where the residual is quiet."""
    fit = pi.identify(arm(), logs[0]).identified
    found = sensor_noise(fit.robot, logs[:1], fit.solution.p)
    for k in range(1, 7):
        assert found[f"joint{k}.e"] == pytest.approx(ENCODER, rel=0.2)
        assert found[f"joint{k}.tau"] < 6 * TORQUE


def test_intervals_are_as_wide_as_the_errors_are_large(logs):
    errors, stds = [], []
    for log in logs:
        found = pi.identify(arm(), log).identified
        names = [n for n in found.reduced.columns if n.startswith("joint") and found.support[n] == "alone"]
        at = [found.reduced.columns.index(n) for n in names]
        errors.append(dict(zip(names, found.solution.p[at] - [truth(n) for n in names], strict=True)))
        stds.append(dict(zip(names, found.solution.std[at], strict=True)))
    names = sorted(set.intersection(*map(set, errors)))
    assert len(names) > 15
    ratios = [
        np.sqrt(np.mean([s[n] ** 2 for s in stds]) / np.mean([e[n] ** 2 for e in errors])) for n in names
    ]
    assert 0.7 < np.median(ratios) < 3
    z = np.array([e[n] / s[n] for e, s in zip(errors, stds, strict=True) for n in names])
    assert np.mean(np.abs(z) < 1.96) > 0.93


def test_errors_on_both_logs_are_without_the_noise_of_encoders(logs):
    """Differenced twice, it would leave many times what the torques' own noise leaves."""
    fit = pi.identify(arm(), logs[0], heldout=logs[1])
    assert "none of the positions" in " ".join(fit.summary().split())
    (unseen,) = fit.heldout.values()
    torques = logs[0].frame[[f"joint{k}.tau" for k in range(1, 7)]].to_numpy()
    alone = 100 * TORQUE * np.sqrt(6) / np.sqrt(np.square(torques).sum(axis=1).mean())
    assert fit.identified.relative_error["all"] < 3 * alone
    assert unseen["all"] < 1.5 * fit.identified.relative_error["all"]
