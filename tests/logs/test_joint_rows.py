"""Tables with a row per joint, in turn, as data frames in their long form are."""

import numpy as np
import pandas as pd
import pytest

from pyident.inspection.inspect_log import inspect_log
from pyident.logs.foreign import import_log
from pyident.logs.formats.read import read_recording
from pyident.logs.log import LogError
from pyident.logs.mapping import read_mapping

TIME = np.arange(60) * 0.01
ANGLES = {"shoulder": np.sin(7 * TIME), "elbow": 2 * np.cos(9 * TIME)}


def rows_of(joints, late=0.0, times=TIME):
    """A row per joint and time; late [s]: how much later the rows of each further joint are stamped."""
    parts = [
        pd.DataFrame({"timestamp": times + i * late, "joint": joint, "position [rad]": x, "effort [Nm]": -x})
        for i, (joint, x) in enumerate(joints.items())
    ]
    return pd.concat(parts).sort_values("timestamp", kind="stable")


def written(folder, frame, ending="csv"):
    path = folder / f"raw.{ending}"
    frame.to_csv(path, index=False) if ending == "csv" else frame.to_parquet(path, index=False)
    return path


@pytest.mark.parametrize("ending", ["csv", "parquet"])
@pytest.mark.parametrize("late", [0.0, 0.004])
def test_each_joint_gets_columns_of_its_own(late, ending, tmp_path):
    path = written(tmp_path, rows_of(ANGLES, late), ending)
    found = inspect_log([path])
    assert {c.column: c.name for c in found.channels if c.signal == "position"} == {
        name: f"joint{k}.e" for k, name in enumerate((n for n in _columns(path) if "position" in n), start=1)
    }
    assert any("the rows of 2 joints alternate, as joint tells" in note for note in found.notes)
    (tmp_path / "m.toml").write_text(found.toml())
    frame = import_log([path], read_mapping(tmp_path / "m.toml")).frame
    time = frame["time"].to_numpy()
    assert frame["joint1.e"].to_numpy() == pytest.approx(np.sin(7 * time))
    assert frame["joint2.e"].to_numpy() == pytest.approx(2 * np.cos(9 * (time - late)), abs=1e-3)


def _columns(path):
    return list(read_recording(path).columns)


@pytest.mark.parametrize("key", ["joint_id", "motor", "axis_no", "can_id"])
def test_joints_may_have_numbers(key, tmp_path):
    frame = rows_of(dict(enumerate(ANGLES.values(), start=1))).rename(columns={"joint": key})
    found = read_recording(written(tmp_path, frame))
    word = key.partition("_")[0].replace("can", "joint")
    assert found.columns[f"{word}2.position"] == pytest.approx(ANGLES["elbow"])
    assert found.columns["timestamp"] == pytest.approx(TIME)
    assert found.units[f"{word}2.effort"] == "Nm"
    assert found.clocks == {}


def test_joints_with_numbers_in_their_names_are_one_by_all_signals(tmp_path):
    """A force beside a torque is not the torque of a joint that turns."""
    names = ("shoulder_pan_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint")
    frame = rows_of({name: (k + 1) * ANGLES["elbow"] for k, name in enumerate(names)})
    frame = frame.assign(force_N=3 * frame["effort [Nm]"]).rename(
        columns={"position [rad]": "position_rad", "effort [Nm]": "torque_Nm"}
    )
    found = inspect_log([written(tmp_path, frame)])
    assert {c.column: c.name for c in found.channels if c.name not in (None, "time")} == {
        f"{name}.{column}": f"joint{k}.{ours}"
        for k, name in enumerate(names, start=1)
        for column, ours in (("position_rad", "e"), ("torque_Nm", "tau"))
    }


def test_a_round_that_was_cut_off_is_left_out(tmp_path):
    found = read_recording(written(tmp_path, rows_of(ANGLES).iloc[:-1]))
    assert len(found.columns["timestamp"]) == len(found.columns["elbow.position"]) == len(TIME) - 1


def test_rows_that_nothing_puts_together_are_refused(tmp_path):
    frame = rows_of(ANGLES).drop(columns="timestamp")
    frame = frame.drop(index=[20, 21, 22]).iloc[3:]
    frame = frame.iloc[np.delete(np.arange(len(frame)), [40, 60, 80])]
    with pytest.raises(
        LogError, match=r'as column joint tells.*frame.pivot\(index="time", columns="joint"\)'
    ):
        read_recording(written(tmp_path, frame))


def test_a_table_in_which_one_joint_after_the_other_is_excited_stays_whole(tmp_path):
    frame = pd.DataFrame({"time": TIME, "joint": np.repeat([1, 2, 3], 20), "q1": TIME, "q2": -TIME})
    assert _columns(written(tmp_path, frame)) == list(frame.columns)


def test_words_that_alternate_are_joints_only_where_their_rows_have_one_stamp(tmp_path):
    tick = pd.DataFrame({"time": TIME, "beat": ["tick", "tock"] * 30, "q1": TIME})
    assert _columns(written(tmp_path, tick)) == ["time", "q1"]
    rows = rows_of(ANGLES).rename(columns={"joint": "name"})
    assert "elbow.effort" in _columns(written(tmp_path, rows))
