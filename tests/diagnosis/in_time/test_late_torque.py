"""One torque that comes late by more than a slope tells is moved in time; laws with a memory are not."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import butter, lfilter, lfilter_zi
from six_axis_logs import COULOMB, VISCOUS, arm, made, plain, three_laws
from two_link_logs import two_link

from pyident.conditioning.alignment import NOTHING, Alignment, OwnWay
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.diagnose import concluded, diagnose
from pyident.diagnosis.late_torque import held_alike
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log

PACE = 2.0  # times a slow motion, so that a joint reverses often


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def with_torque(log: Log, joint: int, tau: np.ndarray) -> Log:
    return replace(log, frame=log.frame.assign(**{f"joint{joint}.tau": tau}))


def later(log: Log, joint: int, samples: float) -> Log:
    time, tau = log.frame["time"].to_numpy(), log.frame[f"joint{joint}.tau"].to_numpy()
    return with_torque(log, joint, np.interp(time - samples * log.period, time, tau))


def held(log: Log) -> Log:
    """Torques of a loop that holds each until the next: logged half a sample before they act."""
    for joint in range(1, 7):
        log = later(log, joint, -0.5)
    return log


def filtered(log: Log, joint: int, corner: float) -> Log:
    """Behind a low pass of two poles, which delays what is slow by sqrt(2)/(2 pi corner)."""
    b, a = np.asarray(butter(2, corner, fs=1 / log.period, output="ba"))
    tau = log.frame[f"joint{joint}.tau"].to_numpy()
    return with_torque(log, joint, lfilter(b, a, tau, zi=lfilter_zi(b, a) * tau[0])[0])


@pytest.mark.slow
def test_a_delay_of_some_samples_is_found_and_leaves_nothing():
    logs = [later(made(arm(), seed, plain, 20.0, PACE), 3, 3.0) for seed in range(2)]
    found = diagnose(arm(), logs[:1], never, logs[1:])
    assert found.verdict == "nothing_detectable"
    assert found.sentence.startswith("The torque of joint3 comes about")
    assert "ms late. That put right: Nothing is missing" in found.sentence
    (note,) = [note for note in found.notes if "was put right" in note]
    assert f"give joint3.tau a delay of about {3.0 * logs[0].period:.2g} s" in note


@pytest.mark.slow
def test_beside_it_all_torques_are_held_by_the_loop():
    logs = [later(held(made(arm(), seed, plain, 20.0, 6.0)), 3, 4.0) for seed in range(2)]
    found = diagnose(arm(), logs[:1], never, logs[1:])
    assert found.verdict == "nothing_detectable"
    assert "the torque of joint3 comes about" in found.sentence


@pytest.mark.slow
def test_a_low_pass_of_one_torque_is_no_presliding():
    logs = [filtered(made(arm(), seed, plain, 20.0, PACE), 2, 9.0) for seed in range(2)]
    found = diagnose(arm(), logs[:1], never, logs[1:])
    assert found.sentence.startswith("The torque of joint2 comes through a low pass of about")
    assert "presliding" not in {n.effect for f in found.findings for n in f.tie}


@pytest.mark.slow
def test_laws_behind_it_are_named():
    logs = [later(made(arm(), seed, three_laws, 20.0, PACE), 5, 4.0) for seed in range(2)]
    found = diagnose(arm(), logs[:1], never, logs[1:])
    assert found.sentence.startswith("The torque of joint5 comes about")
    firsts = {(f.tie[0].effect, f.tie[0].joint) for f in found.findings}
    assert {("load_dependent_friction", "joint2"), ("nonlinear_viscous", "joint1")} <= firsts


@pytest.mark.slow
def test_presliding_is_not_taken_for_it():
    def elastic(q, v, load, time):
        out = COULOMB * np.sign(v) + VISCOUS * v
        force, step = np.zeros(len(q)), np.diff(q[:, 1], prepend=q[0, 1])
        for n in range(1, len(q)):
            force[n] = np.clip(force[n - 1] + step[n] / 0.01, -1, 1)
        out[:, 1] += COULOMB[1] * (force - np.sign(v[:, 1]))
        return out

    logs = [made(arm(), seed, elastic, 30.0) for seed in range(2)]
    search = searched(arm(), logs[:1], never)
    assert search.examination.setting.alignment == NOTHING
    found = concluded(search, never, logs[1:])
    assert ("presliding", "joint2") in {(n.effect, n.joint) for f in found.findings for n in f.tie}
    assert "comes about" not in found.sentence


def test_only_the_torques_that_came_late_are_moved():
    log = made(arm(), 0, plain, 10.0, PACE)
    late = Alignment(own=(OwnWay(3, 3 * log.period),)).of(arm(), later(log, 3, 3.0))
    apart = {c for c in log.frame if not np.array_equal(late.frame[c], log.frame[c])}
    assert apart == {"joint3.tau"}
    inside = slice(10, -10)
    tau = log.frame["joint3.tau"].to_numpy()[inside]
    assert late.frame["joint3.tau"].to_numpy()[inside] == pytest.approx(tau, abs=1e-9)


class _Told:
    """A search of a flexible robot in which a law is named with one coefficient."""

    def __init__(self, coefficient: float, controller: bool = False):
        robot = two_link() if controller else replace(two_link(), controller=None)
        self.robot, self.coefficient = robot, coefficient
        setting = SimpleNamespace(robot=robot, simulates=True, alignment=NOTHING, period=0.004)
        self.examination = SimpleNamespace(setting=setting)

    def resting_on(self, _) -> "_Told":
        return self

    def without(self, _) -> "_Told":
        return self

    def gain_of(self, _):
        return SimpleNamespace(coefficients=np.array([self.coefficient]))


@pytest.mark.parametrize(
    ("late", "coefficient", "held"),
    [
        (Candidate("torque_delay", 2, (("delay", 0.001),)), 2.0, True),  # 2 ms of 4
        (Candidate("torque_delay", 2, (("delay", 0.001),)), 4.0, False),
        (Candidate("torque_lag", 1), -0.002, True),
        (Candidate("torque_lag", 1), 0.002, False),
        (Candidate("stribeck", 1, (("velocity", 0.1),)), 2.0, False),
    ],
)
def test_a_loop_that_holds_the_torque_of_a_joint_that_bends_holds_all(late, coefficient, held):
    told: Any = _Told(coefficient)
    assert held_alike(told, [late]) == (Alignment(held=True) if held else NOTHING)
    known: Any = _Told(coefficient, controller=True)
    assert held_alike(known, [late]) == NOTHING


def test_what_is_held_stays_held_beside_what_else_is_put_right():
    assert Alignment(held=True).then(Alignment(late=0.01)) == Alignment(late=0.01, held=True)
    assert Alignment(late=0.01).then(Alignment(held=True)) == Alignment(late=0.01, held=True)
