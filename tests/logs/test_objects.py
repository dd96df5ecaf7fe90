"""JSON, NumPy archives and packed files: the same columns as from a table of text."""

import bz2
import gzip
import json
import lzma

import numpy as np
import pytest

from pyident.logs.formats.read import read_recording
from pyident.logs.log import LogError

TIME = np.arange(50) * 0.01
Q = np.column_stack([np.sin(TIME), np.cos(3 * TIME)])
STATE = {"time", "q[1]", "q[2]"}


def message(t, q, joints):
    stamp = {"sec": 1_700_000_000 + int(t), "nanosec": round(1e9 * (t % 1))}
    order = [joints.index(joint) for joint in sorted(joints)]
    return {"header": {"stamp": stamp}, "name": joints, "position": [q[order.index(i)] for i in range(2)]}


def lines(rows):
    return "\n".join(map(json.dumps, rows))


@pytest.mark.parametrize(
    "text",
    [
        lines({"time": t, "q": list(q)} for t, q in zip(TIME, Q, strict=True)),
        json.dumps([{"time": t, "q": list(q)} for t, q in zip(TIME, Q, strict=True)]),
        json.dumps({"robot": "x", "rows": [{"time": t, "q": list(q)} for t, q in zip(TIME, Q, strict=True)]}),
        json.dumps({"rate": 100, "time": list(TIME), "q": Q.tolist(), "gains": [1, 2]}),
    ],
)
def test_rows_and_lists_of_json(tmp_path, text):
    path = tmp_path / "a.json"
    path.write_text(text)
    columns = read_recording(path).columns
    assert set(columns) == STATE
    np.testing.assert_array_equal(np.column_stack([columns["q[1]"], columns["q[2]"]]), Q)
    np.testing.assert_array_equal(columns["time"], TIME)


def test_messages_are_put_under_the_joint_that_each_names(tmp_path):
    """The order of the joints changes from message to message; the last was cut off by the recorder."""
    orders = [["elbow", "wrist"], ["wrist", "elbow"]]
    text = lines(message(t, Q[i], orders[i % 2]) for i, t in enumerate(TIME))
    path = tmp_path / "a.jsonl"
    path.write_text(text[:-20])
    read = read_recording(path)
    np.testing.assert_array_equal(read.columns["elbow.position"], Q[:-1, 0])
    np.testing.assert_array_equal(read.columns["wrist.position"], Q[:-1, 1])
    np.testing.assert_allclose(read.columns["header.stamp"], TIME[:-1], atol=1e-8)
    assert read.notes == ("the last line, which is incomplete, left out",)


def test_messages_of_two_topics_have_a_clock_each(tmp_path):
    rows = []
    for t, q in zip(TIME, Q, strict=True):
        rows.append({"topic": "/state", "t": t, "q": list(q)})
        rows.append({"topic": "/drive", "t": t + 0.004, "current": q[0]})
    path = tmp_path / "a.jsonl"
    path.write_text(lines(rows))
    read = read_recording(path)
    clock = read.clocks["current"]
    np.testing.assert_allclose(read.columns[clock], TIME + 0.004)
    np.testing.assert_allclose(read.columns["t"], TIME)


def test_arrays_and_records_of_a_numpy_archive(tmp_path):
    records = np.array(list(zip(TIME, Q[:, 0], strict=True)), dtype=[("t", float), ("speed", float)])
    np.savez(tmp_path / "a.npz", time=TIME, q=Q, log=records, gain=3.0)
    columns = read_recording(tmp_path / "a.npz").columns
    assert set(columns) == STATE | {"log.t", "log.speed"}
    np.testing.assert_array_equal(columns["log.speed"], Q[:, 0])


def test_a_numpy_archive_cannot_run_code(tmp_path):
    np.savez(tmp_path / "a.npz", q=np.array([{"a": 1}], dtype=object))
    with pytest.raises(LogError, match=r"a\.npz cannot be read as npz"):
        read_recording(tmp_path / "a.npz")


@pytest.mark.parametrize(("ending", "packed"), [(".gz", gzip.open), (".bz2", bz2.open), (".xz", lzma.open)])
def test_packed_files(tmp_path, ending, packed):
    text = "time,a\n" + "\n".join(f"{t},{2 * t}" for t in TIME)
    path = tmp_path / f"a.csv{ending}"
    with packed(path, "wt") as file:
        file.write(text)
    np.testing.assert_allclose(read_recording(path).columns["a"], 2 * TIME)
    path.write_text(text)
    with pytest.raises(LogError, match=rf"a\.csv\{ending} cannot be read as {ending[1:]}"):
        read_recording(path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[1, 2, 3]", "holds no rows"),
        ("1\n2\n3", "holds no rows"),
        ("3", "cannot be read as json"),
        ('{"name": "x"}', "holds no column of numbers"),
        ("hello\nworld", "cannot be read as json"),
        ('{"a": 1', "cannot be read as json"),
    ],
)
def test_json_that_holds_no_log(tmp_path, text, says):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(LogError, match=says):
        read_recording(path)
