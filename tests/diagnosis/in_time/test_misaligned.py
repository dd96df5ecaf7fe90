"""Positions that all come late are found by themselves, and what is missing besides behind them."""

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest
from scipy.signal import butter, cont2discrete, filtfilt, lfilter, lfilter_zi
from six_axis_logs import COULOMB, VISCOUS, arm, late, made, plain, three_laws

from pyident.conditioning.alignment import NOTHING, Alignment, OwnWay, earlier
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.misaligned import alignment_of, delay_beside
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log

LATE = 0.9  # samples
PACE = 6.0  # of a slow motion, whose torques hardly change in a sample


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def logs_of(friction, samples: float) -> list[Log]:
    return [late(made(arm(), seed, friction, 20.0, PACE), samples) for seed in range(3)]


def dragging(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    out = plain(q, v, load, time)
    out[:, 2] *= 1 + 1.2 * np.exp(-time / 5)
    return out


def with_noise(log: Log, share: float, seed: int) -> Log:
    noise = np.random.default_rng(100 + seed).standard_normal((len(log.frame), 6))
    names = [f"joint{k}.tau" for k in range(1, 7)]
    torques = log.frame[names].to_numpy(float)
    torques = torques + share * noise * torques.std(axis=0)
    return replace(log, frame=log.frame.assign(**dict(zip(names, torques.T, strict=True))))


@pytest.mark.parametrize("samples", [LATE, pytest.param(-LATE, marks=pytest.mark.slow)])
def test_the_time_is_found_and_nothing_else(samples):
    logs = logs_of(plain, samples)
    search = searched(arm(), logs[:2], never)
    assert search.examination.setting.alignment.late == pytest.approx(samples * logs[0].period, rel=0.15)
    found = concluded(search, never, logs[2:])
    assert found.verdict == "nothing_detectable"
    way = "late" if samples > 0 else "early"
    assert f"ms {way} against the torques. That put right: Nothing is missing" in found.sentence
    assert any("give their columns a delay" in note for note in found.notes)


@pytest.mark.slow
def test_a_quarter_of_a_sample_that_hides_in_the_noise_is_put_right():
    """As of a torque that is held; drives had been called soft, and torques early, one by one."""
    logs = [with_noise(log, 0.06, i) for i, log in enumerate(logs_of(plain, 0.25))]
    search = searched(arm(), logs[:2], never)
    found = search.examination.setting.alignment
    assert found == found.delay
    assert found.late == pytest.approx(0.25 * logs[0].period, rel=0.2)
    assert concluded(search, never, logs[2:]).verdict == "nothing_detectable"


@pytest.mark.slow
def test_what_another_joint_lacks_is_no_witness_of_the_time():
    """A brake that drags for some seconds after every start; two joints' delays had been named instead."""
    logs = [with_noise(log, 0.02, i) for i, log in enumerate(logs_of(dragging, 0.25)[:2])]
    search = searched(arm(), logs, never)
    assert search.examination.setting.alignment.late == pytest.approx(0.25 * logs[0].period, rel=0.2)


@pytest.mark.slow
def test_it_alone_is_named_beside_that_time():
    logs = [with_noise(log, 0.02, i) for i, log in enumerate(logs_of(dragging, 0.25))]
    found = concluded(searched(arm(), logs[:2], never), never, logs[2:])
    assert not any(n.effect.startswith("torque_") for f in found.findings for n in f.tie)
    assert {p.joint for p in found.places if p.over_floor[0] > 1.5} == {"joint3"}


@pytest.mark.slow
def test_laws_behind_it_are_named():
    logs = logs_of(three_laws, LATE)
    found = concluded(searched(arm(), logs[:2], never), never, logs[2:])
    firsts = {(f.tie[0].effect, f.tie[0].joint) for f in found.findings}
    assert {("load_dependent_friction", "joint2"), ("nonlinear_viscous", "joint1")} <= firsts
    assert not any(n.effect == "torque_delay" for f in found.findings for n in f.tie)


def one_late(log: Log, k: int, samples: float) -> Log:
    """The torque of joint k later than the others."""
    time, torque = log.frame["time"].to_numpy(), log.frame[f"joint{k}.tau"].to_numpy()
    moved = np.interp(time - samples * log.period, time, torque)
    return replace(log, frame=log.frame.assign(**{f"joint{k}.tau": moved}))


@pytest.mark.slow
def test_half_a_sample_early_is_a_torque_that_its_loop_holds():
    logs = [one_late(made(arm(), seed, plain, 20.0, 2.0), 3, -0.5) for seed in range(3)]
    assert not concluded(searched(arm(), logs[:2], never), never, logs[2:]).findings


@pytest.mark.parametrize("samples", [0.8, pytest.param(-0.8, marks=pytest.mark.slow)])
def test_one_torque_that_comes_late_is_named_with_its_time(samples):
    logs, k = [one_late(made(arm(), seed, plain, 20.0, 2.0), 3, samples) for seed in range(3)], 3
    found = concluded(searched(arm(), logs[:2], never), never, logs[2:])
    (finding,) = found.findings
    there = {n.effect: n.values for n in finding.tie if n.joint == f"joint{k}"}
    assert there["torque_lag"]["correction"] == pytest.approx(samples * logs[0].period, rel=0.15)
    assert set(there) - {"torque_lag"} == ({"torque_delay"} if samples < 0 else set())
    # with some builds of the libraries a coupling with the motor before it explains just as much
    assert {n.effect for n in finding.tie if n.joint != f"joint{k}"} <= {"joint_coupling"}
    assert any(note.startswith("torque_lag at joint3: give joint3.tau a delay of") for note in found.notes)


def test_positions_in_time_stay_there():
    search = searched(arm(), logs_of(three_laws, 0.0)[:2], never)
    assert search.examination.setting.alignment == NOTHING
    assert alignment_of(search.examination) == NOTHING


def smeared(log: Log, corner: float, poles: int) -> Log:
    """Torques, straight from sample to sample, behind a drive's low pass."""
    analogue = butter(poles, 2 * np.pi * corner, analog=True)
    discrete: Any = cont2discrete(analogue, log.period, method="foh")
    low_pass = discrete[0].ravel(), discrete[1]
    frame = log.frame.copy()
    for name in [name for name in frame if name.endswith(".tau")]:
        tau = frame[name].to_numpy()
        frame[name] = lfilter(*low_pass, tau, zi=lfilter_zi(*low_pass) * tau[0])[0]
    return replace(log, frame=frame)


@pytest.mark.parametrize(("corner", "poles"), [(8.0, 1), pytest.param(10.0, 2, marks=pytest.mark.slow)])
def test_torques_behind_a_low_pass_are_no_presliding(corner, poles):
    """Smeared steps of friction at every joint had passed for it."""
    logs = [smeared(made(arm(), seed, three_laws, 30.0), corner, poles) for seed in range(2)]
    search = searched(arm(), logs[:1], never)
    alignment = search.examination.setting.alignment
    assert (alignment.corner, alignment.poles) == (pytest.approx(corner, rel=0.15), poles)
    found = concluded(search, never, logs[1:])
    assert "torques come through a low pass" in found.sentence
    assert any("log them without it" in note for note in found.notes)
    named = {(f.tie[0].effect, f.tie[0].joint) for f in found.findings}
    laws = {("load_dependent_friction", "joint2"), ("load_dependent_friction", "joint3")}
    assert named == {*laws, ("nonlinear_viscous", "joint1")}


@pytest.mark.slow
def test_torques_smoothed_over_a_record_are_no_presliding_either():
    logs = [made(arm(), seed, three_laws, 30.0) for seed in range(2)]
    both_ways = cast(Any, butter(2, 6.0, fs=1 / logs[0].period))
    for log in logs:
        for name in arm().torques:
            log.frame[name] = filtfilt(both_ways[0], both_ways[1], log.frame[name])
    search = searched(arm(), logs[:1], never)
    alignment = search.examination.setting.alignment
    assert alignment.twice
    assert alignment.corner == pytest.approx(6.0, rel=0.15)
    found = concluded(search, never, logs[1:])
    named = {(f.tie[0].effect, f.tie[0].joint) for f in found.findings}
    laws = {("load_dependent_friction", "joint2"), ("load_dependent_friction", "joint3")}
    assert named >= {*laws, ("nonlinear_viscous", "joint1")}
    assert "presliding" not in {effect for effect, _ in named}
    assert len(named) <= 4  # a `torque_delay` of a joint may be left of the filter


@pytest.mark.slow
def test_presliding_at_every_joint_is_no_low_pass():
    """That depends on the travel since a reversal, which takes another time at each."""

    def elastic(q, v, load, time):
        force, step = np.zeros_like(q), np.diff(q, axis=0, prepend=q[:1])
        for n in range(1, len(q)):
            force[n] = np.clip(force[n - 1] + step[n] / 0.005, -1, 1)
        return COULOMB * force + VISCOUS * v

    logs = [made(arm(), seed, elastic, 30.0) for seed in range(2)]
    search = searched(arm(), logs[:1], never)
    assert search.examination.setting.alignment == NOTHING
    found = concluded(search, never, logs[1:])
    named = [(f.tie[0].effect, f.tie[0].joint) for f in found.findings]
    assert len(named) >= 4
    assert {effect for effect, _ in named} <= {"presliding"}


@pytest.mark.parametrize("poles", [1, 2])
def test_a_low_pass_is_undone(poles):
    log = made(arm(), 0, plain, 5.0, PACE)
    again = Alignment(corner=12.0, poles=poles).of(arm(), smeared(log, 12.0, poles))
    inner = slice(50, -50)
    for name in arm().torques:
        before, after = (np.asarray(each.frame[name])[inner] for each in (log, again))
        behind = np.asarray(smeared(log, 12.0, poles).frame[name])[inner]
        assert np.std(after - before) < 0.25 * np.std(behind - before)  # steps of friction ring


def test_a_log_moved_there_and_back_is_itself():
    log = made(arm(), 0, plain, 5.0, PACE)
    for samples in (2.0, -2.0):
        again = earlier(arm(), late(log, samples), samples * log.period)
        both = log.frame.iloc[20:-20].merge(again.frame, on="time", suffixes=("", ".again"))
        assert len(both) == len(log.frame) - 40
        np.testing.assert_allclose(both["joint2.e.again"], both["joint2.e"], atol=1e-4)


def test_a_moved_log_goes_straight_on_where_it_ends():
    time = np.arange(50) * 0.01
    frame = pd.DataFrame({"time": time} | {f"joint{k}.e": k * time for k in range(1, 7)})
    for moved in (0.033, -0.033):
        found = earlier(arm(), Log(frame, "line"), moved).frame
        np.testing.assert_allclose(found["joint3.e"], 3 * (time + moved), atol=1e-12)


def test_beside_what_was_named_most_joints_measure_one_delay(monkeypatch):
    """As a loop makes it that holds its torque: half a sample, where what was named had hidden it."""
    monkeypatch.setattr("pyident.diagnosis.searched.alignment_of", lambda _: NOTHING)
    logs = logs_of(plain, 0.5)[:2]
    search = searched(arm(), logs, never)
    found = delay_beside(search.examination, [])
    assert found.late == pytest.approx(0.5 * logs[0].period, rel=0.15)


def test_torques_that_were_put_right_go_with_the_positions():
    one = Alignment(own=(OwnWay(3, 0.25),))
    both = one.then(Alignment(0.002, own=(OwnWay(3, 0.5), OwnWay(4, 0.001))))
    assert both == Alignment(0.002, own=(OwnWay(3, 0.75), OwnWay(4, 0.001)))
