"""Clocks as loggers write them: packets twice, stamps of too few digits, cycles that were missed."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyident.inspection.inspect_log import inspect_log
from pyident.logs.clocks import on_one_clock
from pyident.logs.foreign import map_frame
from pyident.logs.log import Log, LogError
from pyident.logs.mapping import Mapping, Source
from pyident.logs.steps import evened, unrounded, usual_step

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


@pytest.mark.parametrize("jitter", [0.0, 2e-4])
def test_cells_that_are_missing_are_filled_as_rows_are(jitter):
    """A log that lacks cells is the one that lacks the rows, but for the other column of those rows."""
    true = 0.008 * COUNT
    frame = recording(true + jitter * np.random.default_rng(0).uniform(-1, 1, len(true)))
    lost = [30, 31, 200, 301, 302, 303, 304]
    log = map_frame(frame.assign(tau=frame["tau"].drop(lost)), MAPPING, "raw")
    said = f"joint1.tau lacks 7 samples, first at {frame['time'][30]:.6g} s: filled in by splines"
    assert log.notes[0] == said
    assert len(log.notes) == (2 if jitter else 1)
    without = map_frame(frame.drop(lost), MAPPING, "raw").frame
    splines = np.interp(log.frame["time"], without["time"], without["joint1.tau"])
    assert log.frame["joint1.tau"].to_numpy() == pytest.approx(splines, abs=3e-5 if jitter else 1e-9)
    assert log.frame["joint1.tau"].to_numpy() == pytest.approx(3 * np.cos(log.frame["time"]), abs=1e-5)


@pytest.mark.parametrize(
    ("lost", "row"),
    [([10, *range(100, 105)], 101), ([10, 0, 1], 1), ([10, 498, 499], 499), ([10, *range(60, 62)], 60)],
)
def test_long_gaps_of_a_column_and_those_at_an_end_are_refused(lost, row):
    """The last: two cells beside three rows that are missing altogether are one gap of five samples."""
    frame = recording(0.008 * COUNT)
    frame = frame.assign(tau=frame["tau"].drop(lost))
    frame = frame.drop([62, 63, 64]) if 60 in lost else frame
    said = (
        rf"joint1.tau is not finite in {len(lost) - 1} rows, first in row {row} .*; cut the log there or fill"
    )
    with pytest.raises(LogError, match=said if row != 60 else "joint1.tau is not finite in 2 rows"):
        map_frame(frame, MAPPING, "raw")


def test_commands_and_switches_that_lack_cells_do_not_swing():
    step = np.where(COUNT < 250, 0.0, 1.0)
    frame = recording(0.008 * COUNT).assign(r=step, on=step)
    frame.loc[249:251, ["r", "on"]] = np.nan
    signals = MAPPING.signals | {"joint1.r": Source("r"), "joint1.on": Source("on")}
    log = map_frame(frame, Mapping(signals), "raw")
    assert log.frame["joint1.r"].to_numpy()[248:253].tolist() == pytest.approx([0, 0.25, 0.5, 0.75, 1])
    assert log.frame["joint1.on"].to_numpy()[248:253].tolist() == [0, 0, 0, 0, 1]
    assert log.notes == (
        "joint1.r lacks 3 samples, first at 1.992 s: filled in by lines",
        "joint1.on lacks 3 samples, first at 1.992 s: filled in by what was held",
    )


def test_a_wrapped_angle_is_joined_over_an_empty_cell():
    frame = recording(0.008 * COUNT)
    frame["q"] = np.mod(2 * frame["time"], 2 * np.pi)
    frame.loc[100, "q"] = np.nan
    signals = MAPPING.signals | {"joint1.e": Source("q", turn=2 * np.pi)}
    log = map_frame(frame, Mapping(signals), "raw")
    assert log.frame["joint1.e"].to_numpy() == pytest.approx(2 * frame["time"].to_numpy())
    assert "jumps by whole turns" in map_frame(frame, MAPPING, "raw").notes[0]


def test_a_column_of_its_own_clock_passes_over_empty_cells():
    raw = {"t": 0.008 * COUNT, "q": np.sin(0.008 * COUNT), "t2": 0.004 * np.arange(1000)}
    tau = 3 * np.cos(raw["t2"])
    tau[[20, 21, 500]] = np.nan
    mapping = Mapping({"time": Source("t"), "joint1.e": Source("q"), "joint1.tau": Source("tau", clock="t2")})
    frame, notes = on_one_clock(raw | {"tau": tau}, mapping, "a.csv")
    assert notes[0] == "joint1.tau lacks 3 of its own samples: passed over"
    assert frame["joint1.tau"].to_numpy() == pytest.approx(3 * np.cos(frame["time"]), abs=1e-6)
    tau[600:605] = np.nan
    with pytest.raises(LogError, match="column tau holds values that are not finite"):
        on_one_clock(raw | {"tau": tau}, mapping, "a.csv")


def test_a_log_of_our_own_names_is_sent_to_the_import_where_that_fills_it():
    frame = recording(0.008 * COUNT).rename(columns={"q": "joint1.e", "tau": "joint1.tau"})
    frame.loc[7, "joint1.tau"] = np.nan
    with pytest.raises(LogError, match=r"row 8 .*; cut the log there or let `pyident log import` fill it"):
        Log.from_frame(frame)
    frame.loc[7:20, "joint1.tau"] = np.nan
    with pytest.raises(LogError, match=r"row 8 .*; cut the log there or fill the gap"):
        Log.from_frame(frame)


@pytest.mark.parametrize(("honest", "said"), [(True, "time was uneven"), (False, "stamps jitter")])
def test_stamps_that_jitter_beside_even_samples_are_no_clock(honest, said):
    """A driver samples every 5 ms and a busy computer stamps; or it samples when it says."""
    even = 0.005 * np.arange(2000)
    stamps = even + 2e-4 * np.random.default_rng(1).standard_normal(len(even))
    sampled = stamps if honest else even
    frame = pd.DataFrame({"time": stamps, "q": np.sin(3 * sampled), "tau": np.cos(3 * sampled)})
    frame = frame.drop(index=[700, 701])  # two were lost
    log = map_frame(frame, MAPPING, "raw")
    assert said in log.notes[0]
    assert any("2 samples are missing" in note for note in log.notes)
    time = log.frame["time"].to_numpy()
    assert log.frame["joint1.e"].to_numpy() == pytest.approx(np.sin(3 * time), abs=1e-4)


@pytest.mark.parametrize("lost", [(), (400, 401, 1300)])
def test_a_stamp_that_is_late_by_itself_is_no_lost_sample(lost):
    even = np.delete(np.arange(2000) * 0.004, lost)
    late = np.zeros(len(even))
    late[[300, 700, 1500]] = 0.0022  # its step rounds to two periods
    stamps = even + late + 3e-4 * np.random.default_rng(1).standard_normal(len(even))
    q = np.sin(3 * even)
    frame, notes = evened(pd.DataFrame({"time": stamps, "joint1.e": q, "joint1.tau": np.cos(even)}), "log")
    assert len(frame) == 2000
    assert notes[0].startswith("stamps jitter")
    assert [n for n in notes if "missing" in n] == ([notes[1]] if lost else [])
    time = frame["time"].to_numpy()
    np.testing.assert_allclose(frame["joint1.e"], np.sin(3 * (time - time[0])), atol=3e-4)


def test_a_clock_that_changes_its_pace_is_no_jitter():
    """A loop is slower while its servo is off; its encoder's steps are coarser than what jitter does."""
    steps = np.where(np.arange(1500) < 900, 0.0035, 0.0053)
    time = np.cumsum(steps + 5e-5 * np.random.default_rng(1).standard_normal(1500))
    q = 0.0015 * np.round(np.sin(2 * np.maximum(time - 1, 0)) / 0.0015)
    frame, notes = evened(pd.DataFrame({"time": time, "joint1.e": q}), "log")
    assert notes[0].startswith("time was uneven")
    assert frame["time"].iloc[-1] == pytest.approx(time[-1], abs=0.0035)
    np.testing.assert_allclose(frame["joint1.e"], np.interp(frame["time"], time, q), atol=0.003)


def test_an_encoder_that_mostly_stands_tells_nothing_of_stamps():
    time = 0.005 * np.arange(1100) + 3e-4 * np.random.default_rng(1).standard_normal(1100)
    q = 0.0015 * np.round(0.02 * np.sin(time) / 0.0015)
    _, notes = evened(pd.DataFrame({"time": time, "joint1.e": q}), "log")
    assert notes[0].startswith("time was uneven")
