"""Recordings of other tools down to their odd columns, and those that cannot be meant."""

import json

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from one_joint import one_joint

from pyident.logs.clocks import on_one_clock
from pyident.logs.foreign import at_joints, delayed
from pyident.logs.formats.parquet import read_parquet
from pyident.logs.formats.read import read_recording
from pyident.logs.log import LogError
from pyident.logs.mapping import read_mapping

TIME = np.arange(50) * 0.01


def written(path, **columns):
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table(columns), path)
    return path


def test_every_kind_of_column_of_a_parquet_file(tmp_path):
    stamps = pd.to_datetime(1_700_000_000_000_000_000 + (TIME * 1e9).astype(int))
    path = written(
        tmp_path / "a.parquet",
        stamp=stamps,
        count=np.arange(50),
        on=TIME > 0.2,
        pair=[[t, 2 * t] for t in TIME],
        single=[[t] for t in TIME],
        ragged=[[t] * (1 + i % 2) for i, t in enumerate(TIME)],
        words=["x"] * 50,
        texts=[["x", "y"]] * 50,
    )
    columns = read_parquet(path).columns
    assert set(columns) == {"stamp", "count", "on", "pair[1]", "pair[2]", "single"}
    np.testing.assert_allclose(columns["stamp"], TIME, atol=1e-6)
    np.testing.assert_allclose(columns["pair[2]"], 2 * TIME)
    assert columns["on"].sum() == (TIME > 0.2).sum()


def data_set(folder, info):
    (folder / "meta").mkdir(parents=True)
    (folder / "meta" / "info.json").write_text(info if isinstance(info, str) else json.dumps(info))
    return folder


def test_a_data_set_names_its_lists_and_tells_its_rate(tmp_path):
    features = {"observation.state": {"names": {"motors": ["pan", "lift"]}}}
    folder = data_set(tmp_path / "set", {"fps": 50, "features": features})
    state = [[t, -t] for t in TIME]
    for number in (0, 1):
        path = folder / "data" / "chunk-000" / f"episode_{number:06d}.parquet"
        written(path, **{"observation.state": state, "episode_index": np.full(50, number)})
    for given in (folder, folder / "meta" / "info.json"):
        found = read_recording(given, episode=1)
        assert found.columns["episode_index"].tolist() == [1.0] * 50
        np.testing.assert_allclose(found.columns["observation.state.lift"], -TIME)
        np.testing.assert_allclose(found.columns["timestamp"], np.arange(50) / 50)
        assert found.units["timestamp"] == "s"
    for episode in (7,):
        with pytest.raises(LogError, match="holds no episode 7"):
            read_recording(folder, episode=episode)


def test_episodes_of_one_file_are_told_apart(tmp_path):
    folder = data_set(tmp_path / "set", {"fps": 50})
    numbers = np.repeat([0, 1], 25)
    path = written(folder / "data" / "file-000.parquet", q=TIME, episode_index=numbers)
    np.testing.assert_allclose(read_recording(folder, episode=1).columns["q"], TIME[25:])
    np.testing.assert_allclose(read_recording(path).columns["q"], TIME[:25])
    for given in (folder, path):
        with pytest.raises(LogError, match="holds no episode 3"):
            read_recording(given, episode=3)


@pytest.mark.parametrize(
    ("info", "sentence"),
    [
        ("{", "cannot be read"),
        ([], "must be a table with a table `features`"),
        ({"features": [1]}, "must be a table with a table `features`"),
        ({"features": {"q": 1}}, "must be a table with a table `features`"),
        ({}, r"has no data/\*\.parquet"),
    ],
)
def test_a_data_set_that_is_none(info, sentence, tmp_path):
    with pytest.raises(LogError, match=sentence):
        read_recording(data_set(tmp_path / "set", info))


def test_what_cannot_be_read_is_one_sentence(tmp_path):
    with pytest.raises(LogError, match=r"there is no log .*none\.csv; check the path"):
        read_recording(tmp_path / "none.csv")
    with pytest.raises(LogError, match=r"is a folder that holds neither meta/info\.json"):
        read_recording(tmp_path)
    with pytest.raises(LogError, match="holds no column of numbers"):
        read_recording(written(tmp_path / "words.parquet", words=["x"] * 3))
    for name in ("a.xlsx", "noise.parquet", "noise.mat"):
        (tmp_path / name).write_bytes(b"noise")
    with pytest.raises(LogError, match=r"a log must end in \.csv"):
        read_recording(tmp_path / "a.xlsx")
    for ending in ("parquet", "mat"):
        with pytest.raises(LogError, match=rf"noise\.{ending} cannot be read as {ending}"):
            read_recording(tmp_path / f"noise.{ending}")


@pytest.fixture
def mapping(tmp_path):
    (tmp_path / "mapping.toml").write_text(
        'joints = 1\ntime = { source = "t", unit = "s" }\n[signals."joint1.e"]\nsource = "q"\n'
        '[signals."joint1.tau"]\nsource = "tau"\nunit = "N.m"\ntime = "slow"\n'
    )
    return read_mapping(tmp_path / "mapping.toml")


def test_a_slower_column_is_brought_to_the_clock_of_time(mapping):
    """Of a cubic, exactly, where its clock reaches."""
    slow = TIME[5:45:4]
    raw = {"t": TIME, "q": TIME**2, "tau": slow**3, "slow": slow}
    frame, notes = on_one_clock(raw, mapping, "a.csv")
    inside = TIME[(slow[0] <= TIME) & (slow[-1] >= TIME)]
    np.testing.assert_allclose(frame["time"], inside)
    np.testing.assert_allclose(frame["joint1.tau"], inside**3, atol=1e-12)
    assert notes == ["joint1.tau was recorded at 25 Hz and brought to the clock of time"]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"slow": TIME[::-1]}, "slow is no clock of tau: it must rise and be as long"),
        ({"slow": TIME[:9]}, "slow is no clock of tau"),
        ({"tau": np.full(50, np.nan)}, "column tau holds values that are not finite"),
        ({"slow": TIME + 100}, "the clocks of its columns do not overlap; check their units"),
        ({"q": TIME[:9]}, "column q has 9 samples, time has 50; name its own clock"),
    ],
)
def test_clocks_that_cannot_be_meant(mapping, changes, sentence):
    with pytest.raises(LogError, match=sentence):
        on_one_clock({"t": TIME, "q": TIME, "tau": TIME, "slow": TIME} | changes, mapping, "a.csv")


def test_a_delay_is_taken_out_of_a_cubic_exactly():
    frame = pd.DataFrame({"time": TIME, "q": TIME**3})
    moved = delayed(frame, {"q": 0.013})
    np.testing.assert_allclose(moved["q"][:-2], (TIME[:-2] + 0.013) ** 3, atol=1e-12)
    for bad in (frame.head(3), frame.iloc[::-1], frame.assign(q=np.nan)):
        assert delayed(bad, {"q": 0.013}) is bad  # the check that follows explains it


def test_motor_columns_without_a_transmission_are_refused():
    frame = pd.DataFrame({"time": TIME, "motor1.q": TIME})
    with pytest.raises(LogError, match=r"column motor1\.q is on the motor side; give the robot"):
        at_joints(frame, one_joint(), "a.csv")
