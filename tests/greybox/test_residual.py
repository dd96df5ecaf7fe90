"""What a residual shows, on residuals made here."""

import numpy as np
import pytest

from pyident.greybox.residual import shown, standing_out

TIME = 0.004 * np.arange(1500)


def course(seed=0):
    """A smooth motion of several frequencies and its speed."""
    rng = np.random.default_rng(seed)
    f, phase = rng.uniform(0.2, 1.5, 5), rng.uniform(0, 6, 5)
    waves = 2 * np.pi * np.outer(TIME, f) + phase
    return np.sin(waves).sum(axis=1), (np.cos(waves) * 2 * np.pi * f).sum(axis=1)


def examined(residual, simulated, signals, angles=()):
    return shown(
        "y",
        "N m",
        [TIME],
        [residual],
        [simulated],
        {k: [v] for k, v in signals.items()},
        {k: [signals[k]] for k in angles},
        1,
    )


def noise(seed):
    return np.random.default_rng(seed).normal(size=len(TIME))


def test_noise_is_seldom_taken_for_a_dependence():
    """White and coloured (a first-order filter with 40 samples), 6 of each: one in twenty by design."""
    angle, speed = course()
    wrong = 0
    for seed in range(6):
        white = noise(seed)
        coloured = np.zeros(len(TIME))
        for i in range(1, len(TIME)):
            coloured[i] = 0.975 * coloured[i - 1] + white[i]
        for residual in (white, coloured):
            wrong += bool(examined(residual, angle, {"angle": angle, "speed": speed}, ["angle"]).findings)
    assert wrong <= 3  # binomial, 12 at 5 %: more in one of a hundred


def test_friction_is_named_by_the_speed():
    angle, speed = course()
    result = examined(
        0.5 * np.sign(speed) + 0.2 * noise(1), angle, {"angle": angle, "speed": speed}, ["angle"]
    )
    first = result.findings[0]
    assert (first.kind, first.of) == ("signal", ("speed",))
    assert first.size == pytest.approx(0.5, rel=0.1)
    assert first.share_percent == pytest.approx(100 * 0.25 / 0.29, abs=5)
    assert result.white_p < 1e-6


def test_a_ripple_is_named_by_its_order():
    angle, speed = course()
    angle = 4 * angle  # several turns
    residual = 0.3 * np.cos(7 * angle + 0.4) + 0.2 * noise(2)
    first = examined(residual, angle, {"angle": angle, "speed": speed}, ["angle"]).findings[0]
    assert (first.kind, first.of, first.at) == ("order", ("angle",), 7)
    assert first.size == pytest.approx(0.3 / np.sqrt(2), rel=0.1)


def test_a_delay_is_measured_between_samples():
    angle, speed = course()
    late = np.interp(TIME - 0.0067, TIME, angle)
    first = examined(late - angle + 0.002 * noise(3), angle, {"angle": angle, "speed": speed}).findings[0]
    assert first.kind == "delay"
    assert first.at == pytest.approx(0.0067, abs=2e-4)


def test_what_only_resembles_a_late_course_is_no_delay():
    """A hundredth of what a delay of 20 ms leaves: as a delay it would leave a hundred times more."""
    angle, speed = course()
    late = np.interp(TIME - 0.02, TIME, angle)
    residual = 0.01 * (late - angle) + 2e-4 * noise(6)
    result = examined(residual, angle, {"angle": angle, "speed": speed}, ["angle"])
    assert [f.of[0] for f in result.findings] == ["speed"]
    assert sum(f.share_percent for f in result.findings) <= 100


def test_two_causes_are_told_one_after_the_other():
    angle, speed = course()
    angle = 4 * angle
    residual = 0.5 * np.sign(speed) + 0.4 * np.sin(7 * angle) + 0.1 * noise(4)
    found = examined(residual, angle, {"angle": angle, "speed": speed}, ["angle"]).findings
    assert {(f.kind, f.of[0]) for f in found[:2]} == {("signal", "speed"), ("order", "angle")}


def test_a_wave_that_follows_nothing_stays_unexplained():
    angle, speed = course()
    wave = np.sin(2 * np.pi * 11.0 * TIME) + 0.1 * noise(5)
    result = examined(wave, angle, {"angle": angle, "speed": speed}, ["angle"])
    assert not result.findings
    assert result.white_p < 1e-6


def test_a_constant_is_told_with_its_size():
    """2 with noise of 0.3: 4 / 4.09 of the energy; a mean within chance, or in slow noise, is none."""
    angle, speed = course()
    signals = {"angle": angle, "speed": speed}
    (found,) = examined(2.0 + 0.3 * noise(7), angle, signals, ["angle"]).findings
    assert (found.kind, found.of) == ("constant", ())
    assert found.at == pytest.approx(2.0, abs=4 * 0.3 / np.sqrt(len(TIME)))
    assert found.share_percent == pytest.approx(100 * 4 / 4.09, abs=0.5)
    slow = np.sin(2 * np.pi * 0.27 * TIME) + 0.1 * noise(8)  # 1.6 waves: their mean is no constant
    for residual in (0.3 * noise(7), slow):
        assert not any(f.kind == "constant" for f in examined(residual, angle, signals).findings)


def test_a_mean_that_stands_out_is_a_sentence():
    residual = np.column_stack([noise(9), 2.0 + 0.3 * noise(10)])
    (said,) = standing_out([("i", "A"), ("w", "rad/s")], [residual])
    size = residual[:, 1].mean()
    assert said == f"what is left of w has a mean of {size:.3g} rad/s: a constant that the model has not"
