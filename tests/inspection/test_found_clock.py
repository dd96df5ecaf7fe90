"""Which column is the clock, and what is said of one that starts again."""

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from pyident.inspection.inspect_log import inspect_log
from pyident.logs.formats.recording import with_whole_stamps

TIME = np.arange(400) * 0.01


def test_the_time_that_every_variable_brings_along_is_the_clock(tmp_path):
    """As a model writes them to a file: a matrix per signal, time its first column."""
    angles = {1: np.sin(TIME), 2: np.cos(3 * TIME)}
    content = {
        "data_theta": np.column_stack([TIME, *angles.values()]),
        "data_tau": np.column_stack([TIME, *(-x for x in angles.values())]),
    }
    savemat(tmp_path / "out.mat", content)
    found = inspect_log([tmp_path / "out.mat"])
    names = {c.column: c.name for c in found.channels}
    assert names == {
        "data_theta[1]": "time", "data_theta[2]": "joint1.e", "data_theta[3]": "joint2.e",
        "data_tau[1]": None, "data_tau[2]": "joint1.tau", "data_tau[3]": "joint2.tau",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("lengths", "said"),
    [
        ((150, 250), "pi_time starts again at row 151: these are 2 recordings in one file; cut it there"),
        ((100, 100, 200), "pi_time starts again at rows 101, 201: these are 3 recordings in one file"),
    ],
)
def test_a_clock_that_starts_again_is_told_as_several_recordings(lengths, said, tmp_path):
    time = np.concatenate([TIME[:n] for n in lengths])
    pd.DataFrame({"pi_time": time, "q1": np.sin(TIME)}).to_csv(tmp_path / "log.csv", index=False)
    asked = inspect_log([tmp_path / "log.csv"]).questions
    assert any(question.startswith(said) for question in asked)
    assert not any("how many samples a second" in question for question in asked)


@pytest.mark.parametrize("ends", [("InSec", "InNanoSec"), (".sec", ".nanosec"), ("_secs", "_nsecs")])
def test_seconds_and_nanoseconds_are_one_time(ends, tmp_path):
    whole = np.floor(TIME + 7.5)
    columns = {f"Zeit{ends[0]}": whole, f"Zeit{ends[1]}": np.round(1e9 * (TIME + 7.5 - whole)), "q": TIME}
    (time, q), values = zip(*with_whole_stamps(columns).items(), strict=True)
    assert (time.startswith("Zeit"), q) == (True, "q")
    assert np.diff(values[0]) == pytest.approx(np.full(399, 0.01))


def test_rows_that_come_again_hide_no_clock_and_no_column(tmp_path):
    """Without names: the time stood still in them, so that the angle behind it was taken for joint 2's."""
    table = np.repeat(np.column_stack([TIME, np.sin(TIME), np.cos(TIME), np.cos(3 * TIME) ** 3]), 3, axis=0)
    np.savetxt(tmp_path / "log.csv", table, delimiter=",")
    found = inspect_log([tmp_path / "log.csv"])
    assert [c.name for c in found.channels] == ["time", "joint1.e", None, "joint1.tau"]
    assert found.channels[0].rate == pytest.approx(100)


def test_rows_that_come_again_without_a_clock_are_told(tmp_path):
    table = np.repeat(np.column_stack([np.sin(TIME), np.cos(3 * TIME)]), 2, axis=0)
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header="q1,tau1", comments="")
    (note,) = inspect_log([tmp_path / "log.csv"], rate=200).notes
    assert note.startswith("400 of 800 rows repeat the row before them")


def test_values_of_joints_that_take_turns_are_told(tmp_path):
    np.savetxt(tmp_path / "time.txt", TIME)
    np.savetxt(tmp_path / "positions.txt", np.sin(np.arange(1200)))
    (note,) = inspect_log([tmp_path / "positions.txt", tmp_path / "time.txt"]).notes
    assert note.startswith("positions:1 holds 1200 values, 3 for each of the 400 of time:1")
