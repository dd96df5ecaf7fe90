"""What an estimate leaves of the torques: white, or slow."""

import numpy as np

from pyident.estimation.slow_rest import slow_rest

PERIOD, SAMPLES = 0.01, 3000


def test_white_noise_is_not_slow_whatever_its_size():
    rng = np.random.default_rng(0)
    for _ in range(50):
        assert slow_rest([rng.standard_normal((SAMPLES, 6)) * [1, 9, 0.1, 1, 1, 1]], [PERIOD]) == ()


def test_noise_that_grows_with_the_frequency_hides_nothing_slow():
    """As twice differenced positions leave it."""
    rng = np.random.default_rng(1)
    assert slow_rest([np.diff(rng.standard_normal((SAMPLES, 2)), 2, axis=0)], [PERIOD]) == ()


def test_a_rest_that_goes_with_gravity_is_said_where_it_is_and_by_how_much():
    rng, time = np.random.default_rng(2), np.arange(SAMPLES) * PERIOD
    quiet = rng.standard_normal((SAMPLES, 3))
    bent = quiet + np.outer(2 * np.sin(2 * np.pi * 0.2 * time), [0, 0, 1])
    (said,) = slow_rest([quiet, bent], [PERIOD, PERIOD])
    assert "at joint3 what it is above 2 Hz" in said
    assert "joint1" not in said
    assert "joint2" not in said
    (twice,) = slow_rest([2 * bent], [PERIOD])
    assert twice == said


def test_a_torque_that_rests_in_one_of_two_logs_is_slow():
    """Another load: the mean of a log is at its slowest frequency."""
    rng = np.random.default_rng(3)
    logs = [rng.standard_normal((SAMPLES, 1)) + side for side in (-0.5, 0.5)]
    assert "joint1" in slow_rest(logs, [PERIOD, PERIOD])[0]


def test_a_log_too_short_to_have_slow_frequencies_tells_nothing():
    assert slow_rest([np.ones((500, 1))], [PERIOD]) == ()


def test_a_rest_of_nothing_is_not_slow():
    assert slow_rest([np.zeros((SAMPLES, 2))], [PERIOD]) == ()
