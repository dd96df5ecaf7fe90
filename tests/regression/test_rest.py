"""Where the sign of dry friction is known, against speeds whose every instant is known."""

import numpy as np
import pytest

from pyident.conditioning.reversals.rest import at_samples, away_from_rest, creeping, without_steps

T = 0.004  # s


def _speed(t: np.ndarray, least: float, shift: float) -> np.ndarray:
    """Positive but for a dip to `least` [rad/s] at 0.2 s and `shift` samples."""
    return 0.3 - (0.3 - least) * np.exp(-(((t - 0.2 - shift * T) / 0.012) ** 2))


def _used(least: float, shift: float) -> tuple[np.ndarray, np.ndarray]:
    """Whether each sample counts, from the means under hats; and its true lowest speed under the hat."""
    k = np.arange(1, 99)
    s = np.linspace(-1, 1, 401)
    inside = _speed((k[:, None] + s) * T, least, shift)
    means = np.trapezoid(inside * (1 - np.abs(s)), s, axis=1)
    return away_from_rest(at_samples(means), float(np.mean(means**2))), inside.min(axis=1)


@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5])
def test_a_dip_below_zero_between_two_samples_is_left_out(shift):
    """At no sample is the mean speed negative or at standstill."""
    used, lowest = _used(-0.004, shift)
    assert (lowest < 0).any()
    assert not used[lowest < 0].any()


@pytest.mark.parametrize("shift", [0.0, 0.5])
def test_a_dip_that_stays_well_above_standstill_counts(shift):
    assert _used(0.05, shift)[0].all()


def test_means_under_hats_become_speeds_at_the_samples():
    t = np.arange(200) * T
    omega = 2 * np.pi * 20
    mean = np.cos(omega * t) * (2 - 2 * np.cos(omega * T)) / (omega * T) ** 2  # of the cosine, exactly
    error = at_samples(mean)[1:-1] - np.cos(omega * t)[1:-1]
    assert np.abs(error).max() < 0.1 * np.abs(mean - np.cos(omega * t)).max()


def _turns(step: float) -> tuple[np.ndarray, np.ndarray]:
    """Whether 4000 samples of a sine are away from rest, and its acceleration with a step at its reversals.

    The step is spread over some ten samples, as by a low pass.
    """
    t = np.arange(4000) * T
    speed = np.cos(2 * np.pi * 0.5 * t)
    blurred = np.convolve(np.sign(speed), np.ones(11) / 11, "same")
    return away_from_rest(speed, 0.5), -np.pi * np.sin(2 * np.pi * 0.5 * t) - step * blurred


def test_a_blurred_step_of_the_acceleration_is_left_out():
    known, acceleration = _turns(2.0)
    kept = without_steps(known, acceleration, 8)
    assert not kept[~known].any()
    assert known.sum() - kept.sum() == pytest.approx(2 * 8 * 16, abs=16)  # sixteen reversals
    assert without_steps(known, acceleration, 1000).mean() > 0.85  # of a tenth at most


def test_quick_stops_are_left_out_before_gentle_ones():
    """A joint stands for long between moves; two of its stops are hard, and a tenth of the samples may go."""
    known = np.zeros(4000, bool)
    known[:1000], known[1400:2400], known[2800:3800] = True, True, True
    acceleration = 0.01 * np.sin(0.05 * np.arange(4000.0))
    acceleration[1000:1010] += 5.0
    acceleration[2400:2410] += 5.0
    kept = without_steps(known, acceleration, 150)
    assert not kept[850:1000].any()
    assert not kept[2250:2400].any()
    assert np.count_nonzero(known & ~kept) <= 400


def test_a_motion_that_turns_round_smoothly_keeps_its_samples():
    known, acceleration = _turns(0.0)
    assert (without_steps(known, acceleration, 8) == known).all()


def test_a_joint_that_gives_way_where_it_stands_does_not_move():
    """Out for 2 s, creeping to and fro for 3 s, back for 2 s; and at last slowly, but somewhere."""
    period = 0.01
    out, stand, slow = np.full(200, 0.5), 0.01 * np.sin(np.arange(300) * 0.03), np.full(400, 0.02)
    speed = np.concatenate([out, stand, -out, slow])
    found = creeping(np.cumsum(speed) * period, speed, period)
    assert found[200:500].all()
    assert not found[:200].any()
    assert not found[500:].any()


def test_a_reversal_is_no_stand():
    period = 0.01
    time = np.arange(0, 20, period)
    assert not creeping(np.sin(2 * time), 2 * np.cos(2 * time), period).any()
    assert not creeping(np.zeros(50), np.zeros(50), period).any()


def test_a_joint_that_lingers_where_it_turns_round_stands_meanwhile():
    """Friction holds it for a sixth of a second between two ramps of speed, as it gives way a little."""
    period, ramp = 0.005, np.arange(0.5, 0.01, -0.0025)
    hold = np.linspace(0.01, -0.01, 34)
    speed = np.concatenate([ramp, hold, -ramp[::-1], ramp[1:] - 0.51, 0.51 - ramp[::-1]])
    found = creeping(np.cumsum(speed) * period, speed, period)
    assert found[len(ramp) : len(ramp) + len(hold)].all()
    beside = slice(len(ramp) - 20, len(ramp) + len(hold) + 20)
    assert not np.delete(found, np.arange(len(speed))[beside]).any()
