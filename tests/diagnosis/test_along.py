"""Replicas of a rigid robot whose loop nobody knows: their noise, their steps, what their search says."""

from dataclasses import replace

import numpy as np
import pytest
from six_axis_logs import arm, made, plain, three_laws

from pyident.conditioning.smooth_motion import blurred, channel_noise, ends_of, reached, smooth
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.order_peaks import order_peaks
from pyident.diagnosis.base.setting import set_up
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched
from pyident.logs.encoders import resolution
from pyident.regression.spectrum import equations
from pyident.rules.rules import RULES
from pyident.simulation.along import along


def never(_):
    raise AssertionError("nothing is simulated where the loop is unknown")


@pytest.fixture(scope="module")
def nothing():
    return [made(arm(), seed, plain, 20.0) for seed in range(3)]


def test_a_smooth_motion_loses_its_noise_and_nothing_else():
    time = np.arange(0, 20, 0.01)
    motion = np.sin(2 * np.pi * 0.7 * time) + 0.3 * np.cos(2 * np.pi * 2.1 * time)
    noise = 1e-4 * np.random.default_rng(0).standard_normal(len(time))
    corner = reached(motion + noise, 1e-4)
    left = smooth(motion + noise, corner) - motion
    ends = ends_of(len(time), [blurred(corner)])
    assert np.std(left[ends:-ends]) < 0.75 * np.std(noise)
    assert (
        np.abs(smooth(motion, reached(motion, 0.0)) - motion)[30:-30].max() < 1e-6
    )  # ends: a continued curvature


def test_what_a_loop_makes_of_its_encoders_noise_is_not_taken_for_motion():
    """A poor loop of 12 Hz amplifies it 2.7 times there. The motion ends at 3 Hz."""
    time = np.arange(0, 20, 0.01)
    motion = np.sin(2 * np.pi * 0.7 * time) + 0.1 * np.cos(2 * np.pi * 3.0 * time)
    noise = 2e-5 * np.random.default_rng(0).standard_normal(len(time))
    s, loop = 2j * np.pi * np.fft.rfftfreq(len(time), 0.01), 2 * np.pi * 12.0
    answer = -np.fft.rfft(noise) * loop**2 / (s**2 + 0.4 * loop * s + loop**2)
    measured = motion + noise + np.fft.irfft(answer, len(time))
    assert 3.0 < 50 * reached(measured, channel_noise(measured)) < 4.0


@pytest.mark.parametrize("step", [1e-3, 1.5339e-3])
def test_the_step_of_a_quantised_channel_is_found(step):
    x = np.sin(np.linspace(0, 20, 4000))
    assert resolution(np.round(x / step) * step) == pytest.approx(step, rel=1e-6)
    assert resolution(x) == 0.0


def test_torque_noise_is_that_of_each_joint(nothing):
    setting = set_up(arm(), nothing[:2])
    for log in nothing[:2]:
        for name in setting.robot.torques:
            true = 0.004 * np.sqrt(np.mean(log.frame[name] ** 2))
            assert setting.own_noise[log.source][name] == pytest.approx(true, rel=0.2)


def test_the_ends_of_a_log_that_begins_in_mid_motion_are_no_noise(nothing):
    """What a difference makes of a motion that nobody knows beyond its ends is not in the torques."""
    part = replace(nothing[0], frame=nothing[0].frame.iloc[137:-211].reset_index(drop=True))
    setting = set_up(arm(), [part, nothing[1]])
    for name in setting.robot.torques:
        true = 0.004 * np.sqrt(np.mean(part.frame[name] ** 2))
        assert setting.own_noise[part.source][name] == pytest.approx(true, rel=0.2)


def test_replicas_differ_in_noise_and_keep_the_steps_of_the_log(nothing):
    setting = set_up(arm(), nothing[:1])
    frame = nothing[0].frame.copy()
    frame["joint1.e"] = np.round(frame["joint1.e"] / 1e-3) * 1e-3
    again = along(setting.robot, replace(nothing[0], frame=frame), setting.solution.p)
    first, second = again.replicas(setting.robot.parameters, (1, 2))
    steps = first.frame["joint1.e"].to_numpy() / 1e-3
    assert np.abs(steps - np.round(steps)).max() < 1e-6
    difference = first.frame["joint3.tau"] - second.frame["joint3.tau"]
    assert np.std(difference) == pytest.approx(np.sqrt(2) * again.noise["joint3.tau"].std, rel=0.1)


def test_known_noise_holds_the_rounding_which_replicas_do_not_add_again(nothing):
    setting, frame = set_up(arm(), nothing[:1]), nothing[0].frame.copy()
    frame["joint1.e"] = np.round(frame["joint1.e"] / 1e-3) * 1e-3
    sigma = float(np.hypot(3e-4, 1e-3 / np.sqrt(12)))
    known = dict.fromkeys([*setting.robot.coordinates, *setting.robot.torques], 0.0) | {"joint1.e": sigma}
    again = along(setting.robot, replace(nothing[0], frame=frame), setting.solution.p, known=known)
    first, second = again.replicas(setting.robot.parameters, (1, 2))
    difference = first.frame["joint1.e"] - second.frame["joint1.e"]
    assert np.std(difference) == pytest.approx(np.sqrt(2) * sigma, rel=0.1)


def test_a_ripple_of_a_gear_is_seen_hundreds_of_times_a_turn():
    def ripple(q, v, load, time):
        out = plain(q, v, load, time)
        out[:, 0] += 1.0 * np.cos(202.0 * q[:, 0])
        return out

    robot = arm()
    logs = [made(robot, seed, ripple, 20.0) for seed in range(2)]
    setting = set_up(robot, logs)
    data = equations(robot, [condition(log, robot) for log in logs], [log.period for log in logs])
    found = order_peaks(robot, data, setting.solution.p, RULES.periodic, range(1, len(robot.joints) + 1))
    assert found[1].steady[0] == pytest.approx(202.0, abs=1.0)
    assert not found[6].steady


def test_nothing_hidden_in_another_simulators_logs_is_nothing_found(nothing):
    search = searched(arm(), nothing[:2], never)
    found = concluded(search, never, nothing[2:])
    assert found.verdict == "nothing_detectable"
    assert {p.state for p in found.places} == {"in_order"}


def test_three_laws_at_three_joints_are_named_each(nothing):
    """The third with its power of the speed: a root."""
    logs = [made(arm(), seed, three_laws, 20.0) for seed in range(3)]
    found = concluded(searched(arm(), logs[:2], never), never, logs[2:])
    ties = [{(n.effect, n.joint) for n in f.tie} for f in found.findings]
    for joint in ("joint2", "joint3"):
        assert any(("load_dependent_friction", joint) in tie for tie in ties), found.sentence
    (grease,) = [f.tie[0] for f in found.findings if f.tie[0].joint == "joint1"]
    assert grease.effect == "nonlinear_viscous", found.sentence
    assert grease.values["power"] == pytest.approx(0.5, abs=0.05)
    assert grease.values["coefficient"] == pytest.approx(9.0, rel=0.1)
    assert not {joint for tie in ties for _, joint in tie} - {"joint1", "joint2", "joint3"}
