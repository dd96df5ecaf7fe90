"""Clocks as loggers write them: packets twice, stamps of too few digits, cycles that were missed."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyident.inspection.inspect_log import inspect_log
from pyident.logs.foreign import map_frame
from pyident.logs.log import LogError
from pyident.logs.mapping import Mapping, Source
from pyident.logs.steps import unrounded, usual_step

COUNT = np.arange(500)
MAPPING = Mapping({"time": Source("time"), "joint1.e": Source("q"), "joint1.tau": Source("tau")})


def recording(time):
    return pd.DataFrame({"time": time, "q": np.sin(time), "tau": 3 * np.cos(time)})


def test_packets_that_come_twice_are_left_out():
    frame = recording(0.001 * COUNT)
    log = map_frame(frame.iloc[np.repeat(COUNT, 1 + (COUNT % 50 == 7))], MAPPING, "raw")
    assert log.notes == ("rows that repeat the row before them, stamp and values, left out: 10",)
    assert log.frame["joint1.tau"].to_numpy() == pytest.approx(frame["tau"].to_numpy())


def test_one_stamp_with_two_values_is_refused():
    frame = recording(0.001 * COUNT)
    frame.loc[8, "time"] = frame.loc[7, "time"]
    with pytest.raises(LogError, match=r"at row 9, which has the stamp .* give rate \(Hz\)"):
        map_frame(frame, MAPPING, "raw")
    frame.loc[8, "time"] = 0
    with pytest.raises(LogError, match="does not increase at row 9; cut the log there"):
        map_frame(frame, MAPPING, "raw")


def test_rows_are_counted_as_the_file_has_them():
    frame = recording(0.001 * COUNT).iloc[np.repeat(COUNT, 1 + (COUNT == 3))].reset_index(drop=True)
    frame.loc[9, "time"] = 0.0
    with pytest.raises(LogError, match="does not increase at row 10;"):
        map_frame(frame, MAPPING, "raw")


@given(
    period=st.floats(1e-3, 0.02),
    digits=st.sampled_from([2, 3]),
    start=st.sampled_from([0.0, 4711.3, 1.7e9]),
    down=st.booleans(),
)
def test_stamps_that_were_rounded_are_even_again(period, digits, start, down):
    true = start + period * COUNT
    given_ = np.floor(true * 10**digits) / 10**digits if down else np.round(true, digits)
    found = unrounded(given_)
    assert usual_step(given_) == pytest.approx(period, rel=0.02) or found is None
    if found is not None:  # 5 and 5.009 ms leave the same stamps of 10 ms: half of one is untold
        assert np.ptp(found - true) < 0.52 * 10**-digits
        assert np.diff(found) == pytest.approx(period, rel=0.01)


def test_a_coarse_clock_is_taken_as_even_and_said_so():
    frame = recording(0.008 * COUNT)
    log = map_frame(frame.assign(time=frame["time"].round(2)), MAPPING, "raw")
    assert log.notes == ("the stamps of time are rounded to 10 ms: taken as even, every 8 ms",)
    assert log.frame["joint1.e"].to_numpy() == pytest.approx(frame["q"].to_numpy())
    assert np.diff(log.frame["time"]) == pytest.approx(0.008, rel=1e-3)


@pytest.mark.parametrize("lost", [[250], [30, 31, 200], list(range(20, 480, 23))])
def test_missing_samples_are_counted_and_not_smeared(lost):
    frame = recording(0.008 * COUNT)
    assert unrounded(frame["time"].drop(lost).to_numpy()) is None or len(lost) > 7
    log = map_frame(frame.drop(lost), MAPPING, "raw")
    said = "1 sample is" if len(lost) == 1 else f"{len(lost)} samples are"
    assert log.notes == (f"{said} missing (at 8 ms a sample): filled in by splines",)
    assert log.frame["joint1.tau"].to_numpy() == pytest.approx(frame["tau"].to_numpy(), abs=1e-5)


def test_a_clock_with_repeats_is_recognised_and_the_stamp_of_the_measurement_preferred(tmp_path):
    time = 0.001 * COUNT
    frame = recording(time).iloc[np.repeat(COUNT, 1 + (COUNT % 50 == 7))]
    frame.to_csv(tmp_path / "raw.csv", index=False)
    guesses = {c.column: c for c in inspect_log([tmp_path / "raw.csv"]).channels}
    assert (guesses["time"].name, guesses["time"].unit) == ("time", "s")
    stamped = pd.DataFrame(
        {"%time": 1e9 * (time + 4e-4), "field.header.stamp": 1e9 * time, "q": np.sin(time)}
    )
    stamped.to_csv(tmp_path / "raw.csv", index=False)
    guesses = {c.column: c.name for c in inspect_log([tmp_path / "raw.csv"]).channels}
    assert guesses["field.header.stamp"] == "time"
    assert guesses["time"] is None
