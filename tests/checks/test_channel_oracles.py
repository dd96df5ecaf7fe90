"""Channels whose step, noise or fault was put in, and so is known."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint

from flexmodels.joint import Limits
from pyident.checks.channels.every_channel import channels
from pyident.checks.channels.jumps import jumps, spikes
from pyident.checks.channels.quantisation import coarse, runs, step_of
from pyident.checks.check_log import check_log
from pyident.checks.whole_log import whole_log
from pyident.logs.encoders import noise_of
from pyident.logs.log import Log, LogError

LIMITS = Limits((-1.0, 1.0), None, None)
TIME = np.arange(2000) * 0.004
ANGLE = np.sin(2 * TIME) + 0.2 * np.sin(11 * TIME)


def logged(**columns) -> Log:
    return Log(
        pd.DataFrame({"time": TIME, "joint1.e": ANGLE, "joint1.tau": np.cos(2 * TIME)} | columns), "a log"
    )


@pytest.mark.parametrize("step", [1e-3, 2 * np.pi / 4096, 0.01])
def test_the_step_of_an_encoder_is_measured(step):
    assert step_of(step * np.round(ANGLE / step)) == pytest.approx(step, rel=1e-6)


def test_what_has_no_step_has_none():
    assert step_of(ANGLE) == 0.0
    assert step_of(np.full(100, 2.0)) == 0.0
    assert step_of(np.array([0.0, 1.0] * 50)) == 0.0  # two values are a switch


def test_the_noise_of_a_smooth_channel_is_measured():
    """The sixth difference of white noise has the variance 924 (the sum of squared binomials)."""
    noise = np.random.default_rng(0).normal(0, 1e-4, len(TIME))
    assert noise_of(ANGLE + noise) == pytest.approx(1e-4, rel=0.1)
    assert noise_of(ANGLE) < 1e-6


def test_runs_of_equal_values_are_counted():
    found = runs(np.array([1.0, 1.0, 1.0, 2.0, 3.0, 3.0]))
    assert found.start.tolist() == [0, 3, 4]
    assert found.length.tolist() == [3, 1, 2]


def test_a_coarse_encoder_is_said_and_one_with_noise_is_not():
    step = 0.02
    rounded = step * np.round(ANGLE / step)
    (defect,) = coarse(one_joint(), logged(), "joint1.e", rounded)
    assert (defect.kind, defect.severity) == ("coarse", "doubtful")
    assert "comes in steps of 0.02" in defect.sentence
    assert not list(coarse(one_joint(), logged(), "joint1.e", ANGLE))


def test_what_follows_a_kink_of_its_reference_is_neither_a_jump_nor_a_spike():
    kinked = ANGLE + 2.0 * np.maximum(TIME - TIME[1200], 0)
    torque = np.cos(2 * TIME) + np.where(np.arange(2000) == 1200, 5.0, 0.0)
    alone, followed = logged(), logged(**{"joint1.r": kinked})
    assert list(jumps(one_joint(), alone, "joint1.e", kinked))
    assert list(spikes(alone, "joint1.tau", torque))
    assert not list(jumps(one_joint(), followed, "joint1.e", kinked))
    assert not list(spikes(followed, "joint1.tau", torque))
    lost = ANGLE + 0.02 * (TIME[600] <= TIME)
    assert list(jumps(one_joint(), followed, "joint1.e", lost))


@pytest.mark.parametrize(("size", "severity"), [(0.02, "doubtful"), (1.0, "gross")])
def test_a_jump_is_told_with_its_size_and_time(size, severity):
    jumped = ANGLE + size * (TIME[1200] <= TIME)
    (defect,) = jumps(one_joint(), logged(), "joint1.e", jumped)
    assert (defect.kind, defect.severity) == ("jump", severity)
    assert f"jumps by {size:.2g} at 4.8 s; a count was lost" in defect.sentence


def test_an_axis_that_stops_within_a_sample_has_not_jumped():
    """It brakes evenly, sticks from a fifth of its pace, and creeps on, as seen at 100 Hz."""
    braking = [0.69, 0.60, 0.51, 0.42, 0.34, 0.267, 0.206, 0.1465, 0.026, 0.0008]
    creeping = [0.005, 0.012, 0.018, 0.0199, 0.019, 0.016, 0.013, 0.0107, 0.008, 0.007]
    time, speed = 0.01 * np.arange(2400), np.zeros(2400)
    speed[:1400] = 0.7 * np.sin(0.5 * time[:1400]) ** 2
    speed[1400:1475] = np.linspace(speed[1399], 0.96, 75)
    speed[1475:1500] = [0.955, 0.94, 0.91, 0.86, 0.78, *braking, *creeping]
    angle = np.cumsum(speed) * 0.01 + np.random.default_rng(0).normal(0, 1e-6, 2400)
    log = Log(pd.DataFrame({"time": time, "joint1.e": angle}), "a log")
    assert not list(jumps(one_joint(), log, "joint1.e", angle))
    lost = angle + 0.02 * (time >= 14.88)
    assert [d.kind for d in jumps(one_joint(), log, "joint1.e", lost)] == ["jump"]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("jitter", [2e-5, 1.5e-4, 1e-3])
def test_the_jitter_of_stamps_is_no_jump_of_a_fast_axis(jitter, seed):
    """Slow but for one fast stroke, as a slider that is mostly positioned: it is off by v times jitter."""
    rng, stamps = np.random.default_rng(seed), 0.004 * np.arange(10_000)
    time = stamps + rng.normal(0, jitter, len(stamps))
    stroke = 0.1 * np.sin(time) + 0.5 * np.tanh((time - 24.0) / 0.15) + rng.normal(0, 1e-6, len(time))
    log = Log(pd.DataFrame({"time": stamps, "joint1.e": stroke}), "a log")
    assert not list(jumps(one_joint(), log, "joint1.e", stroke))
    lost = stroke - 0.05 * (stamps[700] <= stamps)  # while it is slow
    (defect,) = jumps(one_joint(), log, "joint1.e", lost)
    assert " at 2.8 s; a count was lost" in defect.sentence


@pytest.mark.parametrize("at", [850, 1000, 1100])
def test_a_lost_count_of_a_fast_axis_with_even_stamps_is_told(at):
    stroke = 0.5 * np.tanh((TIME - 4.0) / 0.2) + np.random.default_rng(at).normal(0, 1e-6, len(TIME))
    (defect,) = jumps(one_joint(), logged(), "joint1.e", stroke + 1e-3 * (TIME[at] <= TIME))
    assert f" at {TIME[at]:.9g} s; a count was lost" in defect.sentence


def test_a_wrapped_angle_is_told():
    wrapped = np.mod(6 * ANGLE, 2 * np.pi)
    (defect,) = jumps(one_joint(), logged(), "joint1.e", wrapped)
    assert (defect.kind, defect.severity) == ("wrapped", "gross")
    assert "jumps by a turn" in defect.sentence


@pytest.mark.parametrize("sticks", [True, False])
def test_a_hinge_may_jump_where_a_motor_sticks_and_nowhere_else(sticks):
    """A motor brakes evenly, stands still, and the load on its hinge is gone; or it goes on as it was."""
    at, end = 1200, TIME[1200]
    angle = np.where(end > TIME, -0.5 * (TIME - end) ** 2, 0.0) if sticks else ANGLE
    after = np.maximum(TIME - end, 0.0)
    ringing = 1e-4 * np.exp(-40 * after) * np.cos(300 * after)
    hinge = 1e-4 * np.sin(0.5 * TIME) + np.where(np.arange(len(TIME)) >= at, ringing - 1e-4, 0.0)
    found = list(jumps(one_joint(), logged(**{"joint1.e": angle}), "joint1.eps[1]", hinge))
    assert [d.kind for d in found] == ([] if sticks else ["jump"])


def test_a_smooth_channel_has_neither_jumps_nor_spikes():
    assert not list(jumps(one_joint(), logged(), "joint1.e", ANGLE))
    assert not list(spikes(logged(), "joint1.tau", 5 + np.cos(2 * TIME)))


def test_zeros_of_a_small_coarse_noisy_torque_are_not_lost_values():
    """A wrist's current comes in coarse steps and its noise is as large as the torque."""
    noise = np.random.default_rng(1).normal(0.0, 0.15, len(TIME))
    torque = np.round((0.4 * np.cos(2 * TIME) + noise) / 0.033) * 0.033
    assert np.count_nonzero(torque == 0) > 20
    assert not list(spikes(logged(), "joint1.tau", torque))


def test_values_that_were_lost_and_values_that_stick_out_are_told_apart():
    torque = 5 + np.cos(2 * TIME)
    lost = torque.copy()
    lost[[300, 700, 1100, 1500]] = 0.0
    (dropped,) = spikes(logged(), "joint1.tau", lost)
    assert "drops to zero for single samples, 4 times, first at 1.2 s" in dropped.sentence
    wild = torque.copy()
    wild[[300, 700, 1100, 1500]] += 40.0
    (spiked,) = spikes(logged(), "joint1.tau", wild)
    assert spiked.severity == "gross"
    assert "sticks out by 40 for single samples, 4 times, first at 1.2 s" in spiked.sentence


TURNS = np.flatnonzero(np.diff(np.sign(np.gradient(ANGLE))))


def with_dry_friction(late: int = 0) -> np.ndarray:
    """The torque of ANGLE with friction that jumps twice at some of its turns, `late` samples after."""
    turns = TURNS[::5] + late
    torque = 5 + np.cos(2 * TIME) + 0.02 * np.random.default_rng(4).standard_normal(len(TIME))
    torque[turns], torque[turns + 1] = torque[turns] + 0.8, torque[turns + 1] - 0.8
    return torque


@pytest.mark.parametrize("late", [0, 2])
def test_dry_friction_that_jumps_where_its_joint_turns_is_no_spike(late):
    torque = with_dry_friction(late)
    assert list(spikes(Log(logged().frame.drop(columns="joint1.e"), "a log"), "joint1.tau", torque))
    assert not list(spikes(logged(), "joint1.tau", torque))
    shifted = np.concatenate([ANGLE[40:], ANGLE[:40]])  # turns elsewhere
    assert list(spikes(logged(**{"joint1.e": shifted}), "joint1.tau", torque))


def test_a_step_whose_flanks_bend_is_no_spike():
    """Friction of a second motor on the shaft, which turns round elsewhere, behind a low pass."""
    torque = 5 + np.cos(2 * TIME) + 0.01 * np.random.default_rng(4).standard_normal(len(TIME))
    for at in (300, 700, 1100, 1500):
        torque[at - 3 : at] += np.array([1.0, 4.0, 9.0])
        torque[at : at + 3] -= np.array([21.0, 16.0, 12.0])
        torque[at + 3 :] -= 10.0
    assert not list(spikes(logged(), "joint1.tau", torque))


def test_spikes_elsewhere_are_counted_without_those_of_friction_and_large_ones_are_everywhere():
    between = (TURNS[2:8:2] + TURNS[3:9:2]) // 2
    torque = with_dry_friction()
    torque[between] += 0.8
    (told,) = spikes(logged(), "joint1.tau", torque)
    assert f"3 times, first at {TIME[between[0]]:.9g} s" in told.sentence
    torque = with_dry_friction()
    torque[TURNS[4]] += 40.0
    (wide,) = spikes(logged(), "joint1.tau", torque)
    assert (wide.severity, "1 times" in wide.sentence) == ("gross", True)


def kinds(defects, kind: str) -> list[str]:
    return [d.sentence for d in defects if d.kind == kind]


def test_a_position_that_runs_into_its_range_at_full_speed_is_clipped():
    clipped = np.clip(ANGLE, -0.6, 0.6)
    assert any(
        "the channel is clipped" in s
        for s in kinds(channels(one_joint(), logged(**{"joint1.e": clipped})), "limit")
    )
    assert not kinds(channels(one_joint(), logged()), "limit")


@pytest.mark.parametrize(("scale", "severity"), [(1.0, None), (4.0, "doubtful"), (60.0, "gross")])
def test_a_position_far_beyond_the_robot_files_limits_has_another_unit(scale, severity):
    robot = one_joint()
    limited = replace(robot, joints=(replace(robot.joints[0], limits=LIMITS),))
    found = [d for d in whole_log(limited, logged(**{"joint1.e": scale * ANGLE})) if d.kind == "unit"]
    assert [d.severity for d in found] == ([severity] if severity else [])


def test_a_reference_that_stands_for_the_position_is_told():
    told = kinds(whole_log(one_joint(), logged(**{"joint1.r": ANGLE})), "same")
    assert told == [
        "a log: joint1.e and joint1.r are the same numbers; "
        "the reference stands where the measured position should"
    ]


def test_without_positions_there_is_nothing_to_check():
    with pytest.raises(LogError, match=r"a log: column joint1\.e is missing, which robot one_joint needs"):
        check_log(one_joint(), Log(pd.DataFrame({"time": TIME, "joint1.tau": TIME}), "a log"))
    short = logged().frame.head(5)
    assert check_log(one_joint(), Log(short, "a log")) == ()


def in_steps(step: float, frozen: bool) -> Log:
    """Constant speeds, whose torque a coarse sensor shows as one value for long; or one that hangs."""
    rng = np.random.default_rng(3)
    speed = np.where(np.sin(np.pi * TIME) > 0, 0.8, -0.8)
    tau = 9 * np.sign(speed) + 0.05 * rng.standard_normal(len(TIME))
    tau += np.where(np.abs(np.sin(np.pi * TIME)) < 0.4, 0.8 * rng.standard_normal(len(TIME)), 0.0)
    if frozen:
        tau += 2 * np.sin(7 * TIME)
        tau[1000:1400] = tau[1000]
    return logged(**{"joint1.e": np.cumsum(speed) * 0.004, "joint1.tau": step * np.round(tau / step)})


@pytest.mark.parametrize("step", [0.5, 1.0])
def test_a_torque_in_steps_that_keeps_one_is_not_refused(step):
    log = in_steps(step, frozen=False)
    assert runs(log.frame["joint1.tau"].to_numpy()).length.max() > 60
    assert {d.severity for d in channels(one_joint(), log) if d.kind == "stuck"} <= {"doubtful"}


@pytest.mark.parametrize(
    ("step", "severity", "said"), [(0.2, "doubtful", "keeps one value"), (0.01, "gross", "is stuck")]
)
def test_a_torque_that_hangs_is_said_and_refused_where_its_noise_is_seen(step, severity, said):
    (defect,) = [d for d in channels(one_joint(), in_steps(step, frozen=True)) if d.kind == "stuck"]
    assert f"joint1.tau {said} from 4 s" in defect.sentence
    assert defect.severity == severity


def test_a_coarse_encoder_that_rests_at_the_end_is_not_stuck():
    """Its last counts come and go with the noise; one of them is no speed at which a channel could stop."""
    t, step = np.arange(10_000) / 1000, 2 * np.pi / 2**14
    counts = np.round(0.6 * np.cos(0.4 * np.pi * (t - 10)) / step)
    counts[9780:] = counts[9780]
    for number, at in enumerate((9792, 9799, 9808, 9820, 9841, 9885, 9887, 9891, 9895, 9896, 9898, 9899)):
        counts[at:] += 1 if number % 2 else -1
    frame = pd.DataFrame({"time": t, "joint1.e": step * counts, "joint1.tau": -counts})
    assert "stuck" not in {d.kind for d in channels(one_joint(), Log(frame, "log"))}


def test_many_lost_values_and_overflows_hide_none_of_each_other():
    """A jump stands in four fourth differences: of many the 99th percentile is itself one."""
    lost = np.random.default_rng(6).random(len(TIME)) < 0.01
    wrapped = np.mod(ANGLE, 0.6)
    assert np.count_nonzero(np.abs(np.diff(wrapped)) > 0.3) > 0.0025 * len(TIME)
    for spoilt in (np.where(lost, 0.0, ANGLE), wrapped):
        (defect,) = jumps(one_joint(), logged(), "joint1.e", spoilt)
        assert (defect.kind, defect.severity) == ("jump", "gross")


def test_counts_of_an_axis_that_stands_are_no_jumps():
    at_rest = np.zeros(len(TIME))
    at_rest[700:], at_rest[1100:1102], at_rest[1500:] = 1.5e-3, 0.0, 3.1e-3
    assert not list(jumps(one_joint(), logged(), "joint1.e", at_rest))


def test_a_position_that_is_mostly_noise_is_said_and_an_encoder_s_noise_is_not():
    noise = np.random.default_rng(0).normal(0, 1, len(TIME))
    for share, kinds in ((0.05, ["noise"]), (0.005, [])):
        log = logged(**{"joint1.e": ANGLE + share * np.ptp(ANGLE) * noise})
        found = [d.kind for d in channels(one_joint(), log)]
        assert [kind for kind in found if kind == "noise"] == kinds
