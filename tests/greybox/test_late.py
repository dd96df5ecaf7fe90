"""A delay is found beside the parameters of a first-order lag, and no force is taken for one."""

import numpy as np
import pytest

from pyident.greybox.late import confirmed
from pyident.greybox.output_error import output_error
from pyident.greybox.recording import Recording
from pyident.greybox.search import Free

TIME = 0.01 * np.arange(800)


def drive(time):
    return np.sin(2 * np.pi * 0.4 * time) + 0.7 * np.sin(2 * np.pi * 1.3 * time + 1.0)


def answer(gain, lag, time=TIME):
    """Of gain / (1 + lag s) to the waves of the input, long after it began; and twice that."""
    waves = ((1.0, 0.4, 0.0), (0.7, 1.3, 1.0))
    total = np.zeros(len(time))
    for size, f, phase in waves:
        response = gain / (1 + 2j * np.pi * f * lag)
        total += size * abs(response) * np.sin(2 * np.pi * f * time + phase + np.angle(response))
    return np.column_stack([total, 2 * total])


def simulate(recording, sets, names, progress=None):
    return np.array([answer(s["gain"], s["lag"]) for s in sets])


def examined(measured):
    recording = Recording("log", TIME, {"u": drive(TIME)}, ("y", "z"), ("rad", "rad"), measured)
    fit = output_error([recording], simulate, [Free("gain", "", 1.0), Free("lag", "s", 0.1)])
    free = [Free(name, "", value) for name, value in fit.values.items()]
    return fit, confirmed([recording], simulate, free, fit.residuals, {"y": 0.008})


def noise(seed):
    return 0.005 * np.random.default_rng(seed).normal(size=(len(TIME), 2))


def test_a_delay_that_parameters_took_over_in_part_is_found_whole():
    """The lag alone takes over most of 37 ms."""
    fit, late = examined(answer(1.5, 0.2, TIME - 0.037) + noise(0))
    assert fit.values["lag"] > 0.22
    assert late is not None
    assert late.outputs == ("y", "z")
    assert late.delay == pytest.approx(0.037, abs=0.002)
    assert late.values == pytest.approx({"gain": 1.5, "lag": 0.2}, rel=0.02)


def test_one_output_may_be_late_alone():
    measured = np.column_stack([answer(1.5, 0.2, TIME - 0.037)[:, 0], answer(1.5, 0.2)[:, 1]])
    _, late = examined(measured + noise(1))
    assert late is not None
    assert late.outputs == ("y",)
    assert late.delay == pytest.approx(0.037, abs=0.002)


def test_a_ripple_is_no_delay():
    _, late = examined(answer(1.5, 0.2) + 0.2 * np.sin(7 * answer(1.5, 0.2)) + noise(2))
    assert late is None
