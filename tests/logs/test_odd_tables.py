"""Tables that loggers leave behind: cut off, started again, of two sources, in another code page."""

import re

import numpy as np
import pandas as pd
import pytest

from pyident.logs.foreign import import_log
from pyident.logs.formats.delimited import read_delimited
from pyident.logs.formats.hierarchical import read_mat
from pyident.logs.formats.interleaved import with_own_clocks
from pyident.logs.formats.read import read_recording
from pyident.logs.log import LogError
from pyident.logs.mapping import read_mapping

TIME = np.arange(60) * 0.01


def written(folder, text, encoding="utf-8"):
    (folder / "raw.csv").write_bytes(text.encode(encoding))
    return folder / "raw.csv"


def read(folder, text, encoding="utf-8"):
    return read_delimited(written(folder, text, encoding))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
def test_names_do_not_depend_on_the_code_page(encoding, tmp_path):
    found = read(tmp_path, "Zeit [ms];Winkel [°];Öl\n0;1,5;2\n4;2,5;3\n", encoding)
    assert list(found.columns) == ["Zeit", "Winkel", "Öl"]
    assert found.units == {"Zeit": "ms", "Winkel": "°"}
    assert found.columns["Winkel"].tolist() == [1.5, 2.5]


@pytest.mark.parametrize("row", ["[ms]\t[deg]\t[Ncm]", "[ms]\t[]\t[1/rad]", "[s]\t[-]\t[N m]"])
def test_units_in_brackets_are_no_lists(row, tmp_path):
    found = read(tmp_path, f"time\tq1\ttau1\n{row}\n0\t1\t2\n1\t2\t3\n")
    assert list(found.columns) == ["time", "q1", "tau1"]
    assert found.units["tau1"] == row.split("\t")[-1].strip("[]")
    assert found.columns["q1"].tolist() == [1, 2]


@pytest.mark.parametrize(
    "stamps",
    [
        ["12.03.2024 14:07:33,125", "12.03.2024 14:07:33,250", "12.03.2024 14:07:33,375"],
        ["14:07:33.125", "14:07:33.250", "14:07:33.375"],
        ["23:59:59.900", "00:00:00.025", "00:00:00.150"],
        ["31/12/2024 23:59:59.900", "01/01/2025 00:00:00.025", "01/01/2025 00:00:00.150"],
        ["2024-03-12 14:07:33.125", "2024-03-12 14:07:33.250", "2024-03-12 14:07:33.375"],
    ],
)
def test_dates_and_times_of_the_day_are_clocks(stamps, tmp_path):
    found = read(tmp_path, "t;q\n" + "".join(f"{stamp};{i}\n" for i, stamp in enumerate(stamps)))
    assert found.columns["t"] == pytest.approx([0, 0.125, 0.25], abs=1e-9)
    assert found.texts == ()


def test_numbers_as_numpy_2_lists_them(tmp_path):
    rows = "".join(f'{t},"[np.float64({t}), np.float64(-1e-3)]"\n' for t in TIME)
    found = read(tmp_path, "t,q\n" + rows)
    assert list(found.columns) == ["t", "q[1]", "q[2]"]
    assert found.columns["q[1]"] == pytest.approx(TIME)
    assert set(found.columns["q[2]"]) == {-1e-3}


def test_words_are_listed_and_rows_that_are_none_left_out(tmp_path):
    rows = [f"{t:.2f};{t:.4f};Move".replace(".", ",") for t in TIME]
    text = "\n".join(["t;q;mode", *rows[:30], "t;q;mode", *rows[30:], "0,6;0"])
    found = read(tmp_path, text)
    assert found.texts == ("mode",)
    assert found.columns["q"] == pytest.approx(TIME)
    again = "1 row that repeats the line of names left out"
    assert found.notes == ("the last row, which is incomplete, left out", again)
    (tmp_path / "m.toml").write_text('time = {source = "t"}\n[signals."joint1.e"]\nsource = "q"')
    log = import_log([tmp_path / "raw.csv"], read_mapping(tmp_path / "m.toml"))
    assert log.notes[1].endswith(again)
    assert len(log.frame) == len(TIME)


NAMED = "field.name0,field.name1,field.position0,field.position1,field.effort0,field.effort1"


@pytest.mark.parametrize("place", ["", "_"])
def test_the_joints_that_rows_name_decide_also_where_their_order_changes(tmp_path, place):
    rows = [("b", "a", t, -t, 2 * t, 0) if i % 3 else ("a", "b", -t, t, 0, 2 * t) for i, t in enumerate(TIME)]
    body = "".join(f"{t},{','.join(map(str, row))}\n" for t, row in zip(TIME, rows, strict=True))
    named = re.sub(r"(\d)", rf"{place}\1", NAMED)
    found = read(tmp_path, f"%time,{named}\n{body}")
    assert set(found.columns) == {"time", "a.position", "b.position", "a.effort", "b.effort"}
    assert found.columns["b.position"] == pytest.approx(TIME)
    assert found.columns["a.position"] == pytest.approx(-TIME)
    assert found.columns["b.effort"] == pytest.approx(2 * TIME)
    body = body.replace(",a,", ",c,", 5)
    with pytest.raises(LogError, match="name change from row to row"):
        read(tmp_path, f"%time,{named}\n{body}")


def test_sources_whose_rows_alternate_have_a_clock_each(tmp_path):
    a = pd.DataFrame({"__time": TIME, "q": TIME, "dq": 1 + 0 * TIME})
    b = pd.DataFrame({"__time": TIME[::2] + 0.003, "tau": 3 * (TIME[::2] + 0.003)})
    pd.concat([a, b]).sort_values("__time").to_csv(tmp_path / "raw.csv", index=False)
    found = read_delimited(tmp_path / "raw.csv")
    assert found.columns["__time"] == pytest.approx(TIME)
    assert found.clocks == {"tau": "__time of tau"}
    (tmp_path / "m.toml").write_text(
        'time = {source = "__time"}\n[signals."joint1.e"]\nsource = "q"\n'
        '[signals."joint1.tau"]\nsource = "tau"\ntime = "__time of tau"'
    )
    log = import_log([tmp_path / "raw.csv"], read_mapping(tmp_path / "m.toml"))
    assert log.frame["joint1.tau"].to_numpy() == pytest.approx(3 * log.frame["time"].to_numpy())
    assert log.frame["joint1.e"].to_numpy() == pytest.approx(log.frame["time"].to_numpy())


def test_a_column_that_is_filled_now_and_then_has_a_clock_and_one_with_gaps_has_none():
    slow = np.where(np.arange(60) % 10 == 0, TIME, np.nan)
    columns, clocks = with_own_clocks({"time": TIME, "q": np.cos(TIME), "slow": slow})
    assert columns["time of slow"].tolist() == columns["slow"].tolist() == TIME[::10].tolist()
    assert clocks == {"slow": "time of slow"}
    for rows in ([5, 20, 21], [1, 2, 3, 40, 41, 42, 43, 59]):
        gaps = np.cos(TIME)
        gaps[rows] = np.nan
        columns, clocks = with_own_clocks({"time": TIME, "q": np.sin(TIME), "gaps": gaps})
        assert clocks == {}
        assert len(columns["gaps"]) == len(TIME)


@pytest.mark.parametrize(("labels", "names"), [(("q", "tau"), (".q", ".tau")), (("", ""), ("(1)", "(2)"))])
def test_structs_in_an_array_are_told_apart(labels, names, tmp_path):
    from scipy.io import savemat

    signals = np.zeros((1, 2), dtype=[("values", "O"), ("label", "O")])
    for i in range(2):
        signals[0, i] = (np.column_stack([TIME + i, -TIME]), labels[i])
    savemat(tmp_path / "out.mat", {"out": {"time": TIME[:, None], "signals": signals}})
    found = read_mat(tmp_path / "out.mat").columns
    assert set(found) == {"out.time", *(f"out.signals{n}.values[{k}]" for n in names for k in (1, 2))}
    assert found[f"out.signals{names[1]}.values[1]"] == pytest.approx(TIME + 1)


def test_groups_of_joints_on_one_topic_have_a_clock_each(tmp_path):
    """An arm in an order that changes and a gripper at half its rate, both on /joint_states."""
    rosbags = pytest.importorskip("rosbags.rosbag2", reason="the extra `ros` is not installed")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    state, header, stamp = (
        store.types[f"{kind}"]
        for kind in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    with rosbags.Writer(tmp_path / "bag", version=9) as writer:
        topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)

        def write(ns, joints):
            values = np.array(list(joints.values()))
            said = header(stamp(ns // 10**9, ns % 10**9), "")
            message = state(said, list(joints), values, np.zeros(0), 2 * values)
            writer.write(topic, ns, store.serialize_cdr(message, state.__msgtype__))

        for i, t in enumerate(TIME):
            ns = 10**9 + round(1e9 * t)
            if i % 2 == 0:
                write(ns, {"finger": 0.02 + t})
            write(ns + 4_000_000, {"a": t, "b": -t} if i % 3 else {"b": -t, "a": t})
    found = read_recording(tmp_path / "bag")
    assert found.columns["a.position"] == pytest.approx(TIME)
    assert found.columns["b.effort"] == pytest.approx(-2 * TIME)
    assert found.columns["time"] == pytest.approx(TIME + 0.004)
    assert found.columns["finger.time"] == pytest.approx(TIME[::2])
    assert found.columns["finger.position"] == pytest.approx(0.02 + TIME[::2])
    assert found.clocks == dict.fromkeys(("finger.position", "finger.effort"), "finger.time")


def test_sums_and_remarks_at_the_end_are_no_samples(tmp_path):
    rows = "".join(f"{t},{np.sin(t)}\n" for t in TIME)
    found = read(tmp_path, f"time,q1\n{rows}# mean,0.1\nEnd of file\n")
    assert len(found.columns["time"]) == len(TIME)
    assert any("words where numbers are above" in note for note in found.notes)


def test_a_name_that_comes_twice_is_told(tmp_path):
    found = read(tmp_path, "time,q1,q1\n" + "".join(f"{t},{t},{2 * t}\n" for t in TIME))
    assert list(found.columns) == ["time", "q1", "q1 (2)"]
    assert found.columns["q1"].tolist() == TIME.tolist()
    assert found.notes == ("column q1 is there more than once; no. 2 is called 'q1 (2)' here",)


def test_a_column_of_every_axis_gets_one_note(tmp_path):
    """Scopes write the time beside every axis."""
    path = tmp_path / "scope.csv"
    path.write_text("t,q1,t,q2,t,q3\n" + "".join(f"{i},{i},{i},{i},{i},{i}\n" for i in range(30)))
    found = read_recording(path)
    assert found.notes == ("column t is there 3 times; the others are called 't (2)' to 't (3)' here",)


def test_a_cell_without_a_value_here_and_there_makes_no_clocks():
    """One in every column but the time."""
    columns = {"time": TIME, "q1": np.sin(TIME), "tau1": np.cos(TIME), "tau2": 2 * TIME}
    holed = {
        name: np.where(np.arange(60) == 7 + 9 * k, np.nan, x) for k, (name, x) in enumerate(columns.items())
    }
    found, clocks = with_own_clocks(holed | {"time": TIME})
    assert clocks == {}
    assert list(found) == list(columns)
