"""Replicas of a noisy log have the values that are true, and ring as loudly as the log does."""

from dataclasses import replace

import numpy as np
import pytest
from two_link_logs import in_process, loaded, made_log, two_link

from pyident.diagnosis.base.ringing_hinges import _matching, _power, with_ringing_matched
from pyident.diagnosis.base.setting import set_up, unbiased, workers_of

NOISE = 2e-5  # rad, besides that of the log


@pytest.fixture(scope="module")
def noisy(tmp_path_factory):
    """A log of the two links through encoders that are ten times worse."""
    rng = np.random.default_rng(0)
    with loaded(two_link(), tmp_path_factory.mktemp("noisy")) as fmu:
        log = made_log(fmu, two_link(), 1)
    names = [c for c in two_link().coordinates if ".eps[" in c]
    worse = {c: log.frame[c] + NOISE * rng.standard_normal(len(log.frame)) for c in names}
    return replace(log, frame=log.frame.assign(**worse))


def test_noise_does_not_soften_the_replicas(noisy):
    true = two_link().parameters
    setting = set_up(two_link(), [noisy])
    with workers_of(setting, in_process) as workers:
        found = unbiased(setting, workers)
    stiffnesses = [name for name in true if ".k[" in name]
    of_regression, of_replicas = (
        np.array([robot.parameters[name] / true[name] for name in stiffnesses])
        for robot in (setting.robot, found.robot)
    )
    assert of_regression.min() < 0.7
    assert of_replicas == pytest.approx(1.0, abs=0.1)


def test_only_what_the_log_cannot_follow_gets_another_damping(noisy):
    """Bending 2 of joint 2 vibrates at more than 100 Hz, at 250 samples a second."""
    setting = set_up(two_link(), [noisy])
    with workers_of(setting, in_process) as workers:
        found = with_ringing_matched(setting, workers)
    before, after = setting.robot.parameters, found.robot.parameters
    assert {name for name in before if after[name] != before[name]} == {"joint2.d[2]"}
    assert 1 / 16 <= after["joint2.d[2]"] / before["joint2.d[2]"] <= 16


@pytest.mark.parametrize(
    ("louder", "low", "high"),
    [
        ([0.8, 0.0, -0.8], 0.9, 1.1),  # as it is
        ([0.0, -0.8, -1.6], 0.2, 0.4),  # the log is louder: less damping
        ([1.6, 0.8, 0.0], 2.5, 5.0),
        ([0.01, 0.0, -0.01], 0.9, 1.1),  # nothing depends on it
        ([-3.0, -4.0, -5.0], 0.2, 0.3),  # louder than any damping explains
    ],
)
def test_the_damping_that_is_as_loud(louder, low, high):
    assert low < np.exp(_matching(np.array(louder))) < high


def test_the_power_is_that_of_every_equation(noisy):
    setting = set_up(two_link(), [noisy])
    power = _power(setting, [noisy])
    assert power.shape == (len(two_link().coordinates),)
    assert (power > 0).all()
    tau = noisy.frame["joint1.tau"]
    rough = tau + 0.1 * tau.std() * np.random.default_rng(1).standard_normal(len(tau))
    louder = _power(setting, [replace(noisy, frame=noisy.frame.assign(**{"joint1.tau": rough}))])
    assert louder[0] > 2 * power[0]
