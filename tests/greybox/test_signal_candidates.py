"""What a residual may depend on, and what a log and a model have in common, on courses that are known."""

import numpy as np
import pandas as pd
import pytest

from pyident.greybox.candidates import BINS, candidates, delayed
from pyident.greybox.recording import Signals, misses, recording
from pyident.logs.log import Log, LogError
from pyident.rules.confidence import PERIODS

TIME = np.arange(400) * 0.01
COURSE = 3 * TIME


def listed(simulated=COURSE, signals=None, angles=()):
    signals = signals or {}
    turning = {name: [signals[name]] for name in angles}
    return list(candidates([TIME], [simulated], {n: [v] for n, v in signals.items()}, turning))


def test_a_delay_of_a_line_is_a_constant():
    inside = slice(70, -70)
    for candidate in listed():
        assert candidate.kind == "delay"
        np.testing.assert_allclose(candidate.columns[0][inside, 0], -3 * candidate.at, atol=1e-12)
    np.testing.assert_allclose(delayed(TIME, COURSE, 0.05)[inside], COURSE[inside] - 0.15)
    assert {c.at for c in listed()} >= {0.01, -0.01, 0.64, -0.64}


def test_a_course_that_stands_has_no_delay():
    assert listed(np.full(400, 2.0)) == []


def test_orders_begin_where_the_angle_shows_enough_periods():
    """Of half a turn, order n shows n / 2 periods."""
    angle = np.linspace(0, np.pi, 400)
    orders = [c for c in listed(signals={"q": angle}, angles=["q"]) if c.kind == "order"]
    assert orders[0].at == np.ceil(2 * PERIODS)
    first = orders[0].columns[0]
    np.testing.assert_allclose(first[:, 0] ** 2 + first[:, 1] ** 2, 1.0)
    still = listed(signals={"q": np.zeros(400)}, angles=["q"])
    assert {c.kind for c in still} == {"delay"}


def test_a_signal_is_cut_into_parts_of_equal_share():
    (signal,) = [c for c in listed(signals={"x": TIME**2}) if c.kind == "signal"]
    parts = signal.columns[0]
    assert parts.shape == (400, BINS)
    assert np.ptp(parts.sum(axis=0)) <= 1
    np.testing.assert_array_equal(parts.sum(axis=1), 1.0)


def test_a_recording_is_what_log_and_model_share():
    log = Log(pd.DataFrame({"time": TIME, "u": COURSE, "y": TIME, "other": TIME}), "a log")
    offered = Signals({"u": None, "w": 2.5}, {"y": "rad", "z": "m"})
    taken, notes = recording(log, offered)
    assert (taken.outputs, taken.units, list(taken.inputs)) == (("y",), ("rad",), ["u"])
    assert notes == ("a log: inputs without a column keep their start value: w = 2.5",)
    left = misses(
        [taken], lambda recording, sets, names, progress=None: np.full((1, 400, 1), sets[0]["c"]), {"c": 1.0}
    )
    np.testing.assert_allclose(left[0][:, 0], TIME - 1.0)
    many = Signals({f"w{i}": 0.0 for i in range(6)}, {"y": "rad"})
    assert recording(log, many)[1][0].endswith("w3 = 0 and 2 more")


@pytest.mark.parametrize(
    ("signals", "sentence"),
    [
        (Signals({}, {"z": "m"}), "no column is an output of the model; its outputs are z"),
        (Signals({}, {}), "its outputs are none"),
        (Signals({"v": None}, {"y": "rad"}), "column v is missing, an input of the model that has no start"),
    ],
)
def test_a_log_that_the_model_does_not_know_is_refused(signals, sentence):
    log = Log(pd.DataFrame({"time": TIME, "y": TIME}), "a log")
    with pytest.raises(LogError, match=sentence):
        recording(log, signals)


def test_what_stands_still_but_for_rounding_is_no_candidate():
    """Of an angle at 0.3 rad whose last bit flickers; orders of it would be a thousand constants."""
    flicker = 0.3 * (1 + 2e-16 * (np.arange(400) % 2))
    assert {c.kind for c in listed(signals={"q": flicker}, angles=["q"])} == {"delay"}
