"""Positions on another clock than the torques: found, put right, and known to the intervals."""

import re
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from studies.rigid_arm.arm import arm, moved, recorded

import pyident as pi
from pyident.refinement import auxiliary_model
from pyident.refinement.auxiliary_model import identify_by_instruments
from pyident.refinement.instruments.positions_late import Late, _common

DELAY = 0.002  # s, of all torques, as behind a low pass of 80 Hz
PERIOD = 0.004


@pytest.fixture(scope="module")
def fits():
    """Of the same motion with torques as they are, all late, and late at one joint alone."""
    pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")
    made, delays = (
        {},
        {"none": np.zeros(6), "all": np.full(6, DELAY), "one": np.array([DELAY, 0, 0, 0, 0, 0])},
    )
    for name, late in delays.items():
        rng, robot = np.random.default_rng(4), arm()
        motion = moved(robot, rng, 15.0, 4.0)
        time, pairs = motion.time, zip(motion.load.T, late, strict=True)
        torques = np.column_stack([CubicSpline(time, x)(np.maximum(time - d, 0)) for x, d in pairs])
        made[name] = pi.identify(robot, recorded(motion, torques, 0.01 * motion.load.std(axis=0), rng, "log"))
    return made


def moved_by(fit) -> float | None:
    """ms, of the note."""
    told = [re.search(r"all positions come ([\d.]+) ± ([\d.]+) ms (\w+)", note) for note in fit.notes]
    return next((float(m[1]) * (-1 if m[3] == "early" else 1) for m in told if m), None)


def zeros(fit) -> np.ndarray:
    """Frictions and rotors, which the arm has not, over their standard deviations."""
    found = fit.identified
    names = enumerate(found.reduced.columns)
    told = [i for i, n in names if n.startswith("joint") and found.support[n] == "alone"]
    return found.solution.p[told] / found.solution.std[told]


def test_nothing_is_moved_where_clocks_agree(fits):
    assert moved_by(fits["none"]) is None


def test_torques_that_are_all_late_are_put_right(fits):
    assert moved_by(fits["all"]) == pytest.approx(-1e3 * DELAY, rel=0.1)
    assert np.abs(zeros(fits["all"])).max() < 4
    assert np.sqrt(np.mean(np.square(zeros(fits["all"])))) < 1.5


def test_one_late_torque_is_no_clock(fits):
    assert moved_by(fits["one"]) is None


def common(times: list[float], stds: list[float]):
    """Of two joints, each in two parts, with slopes of 1."""
    return _common(np.array(times), np.diag(np.square(stds)), np.ones((2, 4)), np.array([0, 0, 1, 1]), PERIOD)


def test_times_that_agree_are_one():
    late = common([1.0e-3, 1.1e-3, 0.9e-3, 1.0e-3], [5e-5] * 4)
    assert late.sure
    assert (late.time, late.std) == pytest.approx((1e-3, 2.5e-5))
    np.testing.assert_allclose(late.variance, (4 * late.std) ** 2 * np.ones((2, 2)))


@pytest.mark.parametrize("times", [[1.0e-3, 1.1e-3, 0.9e-3, 2.0e-3], [6 * PERIOD] * 4])
def test_of_times_that_differ_or_are_too_long_no_more_is_known_than_before(times):
    late = common(times, [5e-5] * 4)
    assert not late.sure
    assert (late.time, late.std) == (0.0, PERIOD / 2)


def test_a_time_that_is_not_sure_widens_the_intervals():
    """By itself, where it is one joint's doing; by what is not known of it, where it is chance."""
    alone = common([1e-3] * 4, [5e-5, 5e-5, 2e-3, 2e-3])
    chance = common([1e-3] * 4, [2e-3] * 4)
    assert not alone.sure
    assert not chance.sure
    assert alone.std == pytest.approx(1e-3, rel=0.01)
    assert chance.std == pytest.approx(((2e-3 / 2) ** -2 + (PERIOD / 2) ** -2) ** -0.5)


@pytest.mark.parametrize(("samples", "sure"), [(0.5, True), (-0.45, True), (0.8, False)])
def test_one_joint_alone_tells_that_its_torque_is_held_and_no_other_time(samples, sure):
    late = _common(np.full(2, samples * PERIOD), 1e-12 * np.eye(2), np.ones((2, 2)), np.array([0, 0]), PERIOD)
    assert late.sure == sure
    assert late.std == pytest.approx(7.1e-7 if sure else abs(samples) * PERIOD, rel=0.01)


@dataclass(frozen=True)
class Found:
    relative_error: dict[str, float]
    notes: tuple[str, ...] = ()


def test_what_leaves_more_when_it_is_put_right_is_no_delay(monkeypatch):
    """As a loop's answer to its encoders' noise looks like one."""
    times = iter([Late(-0.004, 2e-4, np.zeros(1), True), None] * 2)
    for after, put_right in ((4.25, False), (4.15, True)):
        errors = iter([4.2, after])

        def identified(*_, errors=errors):
            error = next(errors)
            return Found({"all": error}), next(times), SimpleNamespace(in_motion=error**2)

        monkeypatch.setattr(auxiliary_model, "_identified", identified)
        found = identify_by_instruments(arm(), [], cast(Any, None))
        assert found.relative_error["all"] == (after if put_right else 4.2)
        assert any("all positions come 4" in note for note in found.notes) == put_right
