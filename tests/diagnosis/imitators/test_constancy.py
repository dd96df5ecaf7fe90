"""A true law's coefficients are the same under much and little torque, whatever the torque's noise."""

from dataclasses import replace

import numpy as np
import pytest
from six_axis_logs import arm, made, plain

from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate, columns
from pyident.diagnosis.base.projection import extended, gain, solve_base
from pyident.diagnosis.base.setting import set_up
from pyident.diagnosis.imitators.constancy import QUANTITIES
from pyident.regression.spectrum import equations

LAW = Candidate("load_dependent_friction", 2)
NOISE = 0.05  # of the torque's rms


def loaded(q, v, load, time):
    out = plain(q, v, load, time)
    out[:, 1] += 0.12 * np.abs(load[:, 1]) * np.sign(v[:, 1])
    return out


def noisy(robot, seed: int):
    """White noise on every torque; the law is true."""
    log = made(robot, seed, loaded, 20.0)
    rng, torques = np.random.default_rng(100 + seed), [f"joint{k}.tau" for k in range(1, 7)]
    tau = log.frame[torques].to_numpy()
    noise = NOISE * np.sqrt(np.mean(tau**2, axis=0)) * rng.standard_normal(tau.shape)
    return replace(log, frame=log.frame.assign(**dict(zip(torques, (tau + noise).T, strict=True))))


@pytest.fixture(scope="module")
def examined():
    """The fitted robot, its equations over what the fit leaves, and that level."""
    robot = arm()
    logs = [noisy(robot, seed) for seed in range(2)]
    setting = set_up(robot, logs)
    raw = equations(robot, [condition(log, robot) for log in logs], [log.period for log in logs])
    level = 1 / setting.solution.weights
    levels = [np.repeat(level[:, None], e.y.shape[1], axis=1) for e in raw]
    return setting.robot, [e.over(of) for e, of in zip(raw, levels, strict=True)], levels


def share(examined, values) -> float:
    """What coefficients of their own above the median take, over what the law itself does."""
    robot, data, levels = examined
    base, X = solve_base(data), columns(robot, LAW, data, levels)
    middle = np.median(np.concatenate(values))
    high = columns(robot, LAW, data, levels, [(v > middle).astype(float) for v in values])
    return gain(extended(base, X), high).energy / gain(base, X).energy


def test_a_true_laws_coefficients_do_not_change(examined):
    robot, data, _ = examined
    for name, quantity in QUANTITIES.items():
        assert share(examined, [quantity(robot, log, 1) for log in data]) < 0.05, name


def test_samples_chosen_by_the_measured_torque_are_chosen_by_its_noise(examined):
    """Why the model's torque is taken: what is measured would make a true law an imitator."""
    _, data, _ = examined
    assert share(examined, [np.abs(log.part.target[:, 1]) for log in data]) > 0.25
