"""Files as other tools write them, and the grammar of mappings beyond names and units."""

from array import array

import numpy as np
import pandas as pd
import pytest

from pyident.logs.foreign import import_log
from pyident.logs.formats.delimited import read_delimited
from pyident.logs.formats.hierarchical import read_hdf5
from pyident.logs.formats.layout import layout_of
from pyident.logs.formats.parquet import read_parquet
from pyident.logs.indices import at_joint
from pyident.logs.log import LogError
from pyident.logs.mapping import read_mapping


def mapping(folder, text):
    (folder / "mapping.toml").write_text(text)
    return read_mapping(folder / "mapping.toml")


@pytest.mark.parametrize(
    ("text", "names", "first"),
    [
        ("a,b\n1,2\n3,4\n5,6\n", ("a", "b"), [1, 3, 5]),
        ("a;b\n1,5;2\n3;4\n5;6,5\n", ("a", "b"), [1.5, 3, 5]),
        ("# made by x\na\tb\ns\tdeg\n1\t2\n3\t4\n5\t6\n", ("a", "b"), [1, 3, 5]),
        ("1 2\n3 4\n5 6\n", ("1", "2"), [1, 3, 5]),
        ("a|b\n1e3|2\n-3|4\n.5|6\n", ("a", "b"), [1000, -3, 0.5]),
        ("a,b,note\n1,2,x\n3,4,y\n5,6,z\n", ("a", "b"), [1, 3, 5]),
        ('a,b\n1,"[2, 3]"\n3,"[4, 5]"\n5,"[6, 7]"\n', ("a", "b[1]", "b[2]"), [1, 3, 5]),
        ("a\n1\n3\n5\n", ("a",), [1, 3, 5]),
        (
            "a,b\n2026-01-01T00:00:01Z,2\n2026-01-01T00:00:03Z,4\n2026-01-01T00:00:05Z,6\n",
            ("a", "b"),
            [0, 2, 4],
        ),
    ],
)
def test_tables_of_text(text, names, first, tmp_path):
    (tmp_path / "raw.csv").write_text(text)
    found = read_delimited(tmp_path / "raw.csv")
    assert tuple(found.columns) == names
    assert found.columns[names[0]].tolist() == first


def test_units_stand_in_a_row_or_in_the_names(tmp_path):
    (tmp_path / "raw.csv").write_text("t;q\nms;°\n0;1\n4;2\n8;3\n")
    assert read_delimited(tmp_path / "raw.csv").units == {"t": "ms", "q": "°"}
    (tmp_path / "raw.csv").write_text("Zeit [s];Winkel [°]\n0;1,5\n4;2,5\n")
    found = read_delimited(tmp_path / "raw.csv")
    assert found.units == {"Zeit": "s", "Winkel": "°"}
    assert layout_of(tmp_path / "raw.csv").decimal == ","


def test_points_between_thousands_are_no_decimal_signs(tmp_path):
    """A column without commas may have decimal points of its own."""
    rows = "".join(
        f"{0.004 * i:.3f};1.{i:03d},50;{-2 * i},25;1.{i:03d}\n".replace("0.", "0,", 1) for i in range(9)
    )
    (tmp_path / "raw.csv").write_text(f"Zeit [s];M1 [Nm];M2 [Nm];x\n{rows}")
    found = read_delimited(tmp_path / "raw.csv").columns
    assert found["M1"].tolist() == [1000.5 + i for i in range(9)]
    assert found["M2"][1] == -2.25
    assert found["x"][1] == 1.001


def test_a_text_without_numbers_is_explained(tmp_path):
    (tmp_path / "raw.csv").write_text("some,words\nand,others\n")
    with pytest.raises(LogError, match="no rows of numbers"):
        read_delimited(tmp_path / "raw.csv")


def test_an_episode_of_a_data_set_is_chosen(tmp_path):
    (tmp_path / "meta").mkdir()
    (tmp_path / "meta" / "info.json").write_text(
        '{"fps": 30, "features": {"observation.state": {"names": {"motors": ["pan", "lift"]}}}}'
    )
    (tmp_path / "data" / "chunk-000").mkdir(parents=True)
    state = [[float(i), -float(i)] for i in range(6)]
    frame = pd.DataFrame({"observation.state": state, "episode_index": [0, 0, 0, 1, 1, 1]})
    frame.to_parquet(tmp_path / "data" / "chunk-000" / "file-000.parquet")
    found = read_parquet(tmp_path, 1)
    assert found.columns["observation.state.lift"].tolist() == [-3, -4, -5]
    np.testing.assert_allclose(found.columns["timestamp"], np.arange(3) / 30)
    with pytest.raises(LogError, match="no episode 7"):
        read_parquet(tmp_path, 7)


def test_two_rates_come_to_one_clock(tmp_path):
    h5py = pytest.importorskip("h5py")
    fast, slow = np.arange(0, 4, 0.004), np.arange(0.002, 3.9, 0.01)
    with h5py.File(tmp_path / "raw.h5", "w") as file:
        file["encoder/t"], file["encoder/q"] = fast, np.sin(fast)
        file["drive/t"], file["drive/tau"] = slow, np.cos(slow)
    assert read_hdf5(tmp_path / "raw.h5").clocks["drive/tau"] == "drive/t"
    text = (
        'time = {source = "encoder/t"}\n[signals."joint1.e"]\nsource = "encoder/q"\n[signals."joint1.tau"]\n'
    )
    log = import_log(
        [tmp_path / "raw.h5"], mapping(tmp_path, f'{text}source = "drive/tau"\ntime = "drive/t"')
    )
    np.testing.assert_allclose(log.frame["joint1.tau"], np.cos(log.frame["time"]), atol=1e-6)
    assert "joint1.tau was recorded at 100 Hz" in log.notes[0]
    with pytest.raises(LogError, match="name its own clock"):
        import_log([tmp_path / "raw.h5"], mapping(tmp_path, f'{text}source = "drive/tau"'))


@pytest.mark.parametrize(
    ("pattern", "k", "name"), [("col{k+13}", 2, "col15"), ("x{2*k-1}", 3, "x5"), ("q[{k}]", 4, "q[4]")]
)
def test_indices_may_be_reckoned(pattern, k, name):
    assert at_joint(pattern, k) == name


@pytest.mark.parametrize("pattern", ["{k.x}", "{__import__('os')}", "{k**9999}", "{}", "{1/k}", "{k+1e9}"])
def test_nothing_but_whole_numbers_is_reckoned(pattern):
    with pytest.raises(LogError, match="no whole number"):
        at_joint(pattern, 2)


def test_drives_and_gears_are_facts_of_the_mapping(tmp_path):
    frame = pd.DataFrame({"m0": [0.0, 1, 2, 3], "m1": [1.0, 1, 1, 1], "i1": [2.0, 2, 2, 2]})
    frame.to_csv(tmp_path / "raw.csv", index=False)
    m = mapping(
        tmp_path,
        'rate = 10\n[signals."joint{k}.e"]\nsource = "m{k-1}"\nunit = "rev"\ngear = 100\n'
        '[signals."joint{k}.tau"]\nsource = "i{k}"\nunit = "A"\ndrive = 0.5\ngear = 100\nsign = -1',
    )
    log = import_log([tmp_path / "raw.csv"], m)
    np.testing.assert_allclose(log.frame["joint1.e"], 2 * np.pi * np.arange(4) / 100)
    np.testing.assert_allclose(log.frame["joint1.tau"], -100.0)


def test_a_counter_that_overflows_is_unwrapped_before_its_gear(tmp_path):
    counts = np.arange(0, 9000, 500)
    pd.DataFrame({"n": counts % 4096}).to_csv(tmp_path / "raw.csv", index=False)
    facts = f"gain = {2 * np.pi / 4096}\nunwrap = 4096\ngear = -50"
    m = mapping(tmp_path, f'rate = 10\n[signals."joint1.e"]\nsource = "n"\n{facts}')
    log = import_log([tmp_path / "raw.csv"], m)
    np.testing.assert_allclose(log.frame["joint1.e"], -2 * np.pi * counts / 4096 / 50)


@pytest.mark.parametrize(
    ("facts", "torque"),
    [
        ('unit = "%"\nrated = 300', 6.0),
        ('unit = "1"\ndrive = 3', 6.0),
        ('unit = "mA"\ndrive = 3', 6e-3),
        ('unit = "A"\ndrive = 1', 2.0),
    ],
)
def test_a_drive_is_per_ampere_or_column_and_a_rated_torque_at_100_percent(facts, torque, tmp_path):
    pd.DataFrame({"i": [2.0] * 4}).to_csv(tmp_path / "raw.csv", index=False)
    m = mapping(tmp_path, f'rate = 10\n[signals."joint1.tau"]\nsource = "i"\n{facts}')
    np.testing.assert_allclose(import_log([tmp_path / "raw.csv"], m).frame["joint1.tau"], torque)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('time = {source = "t"}\n[signals."joint1.e"]\nsource = "t"', "column t is the column of time and"),
        (
            'rate = 1\n[signals."joint1.e"]\nsource = "a"\n[signals."joint1.tau"]\nsource = "a"',
            "mapped twice",
        ),
        ('rate = 1\n[signals."joint1.e"]\nsource = "a"\ndrive = 2', "only a torque has a drive"),
        ('rate = 1\n[signals."joint1.e"]\nsource = "a"\ngear = 0', "a gear must not be 0"),
        ('rate = 1\n[signals."joint1.e"]\nsource = "a"\nunwrap = true', "only an angle is unwrapped"),
        ('rate = 1\n[signals."joint1.tau"]\nsource = "a"\nunwrap = 4096', "only an angle is unwrapped"),
        ('rate = 1\n[signals."joint1.e"]\nsource = "a"\nunwrap = 0', "unwrap = 0 must be above 0"),
        ('rate = 1\n[signals."joint1.tau"]\nsource = "a"\nunit = "mA"', "needs drive = .* per A"),
        ('rate = 1\n[signals."joint1.tau"]\nsource = "a"\nunit = "V"', "needs drive = .* per V"),
        ('rate = 1\n[signals."joint1.tau"]\nsource = "a"\nunit = "%"', "at 100 %, and no drive"),
        ('rate = 1\n[signals."joint1.tau"]\nsource = "a"\nunit = "%"\ndrive = 3', "at 100 %, and no drive"),
        ('rate = 1\n[signals."joint1.tau"]\nsource = "a"\nrated = 300', "in % or ‰ has a rated value"),
        (
            'rate = 1\n[signals."joint1.e"]\nsource = "a"\nunit = "%"\nrated = 3',
            "in % or ‰ has a rated value",
        ),
    ],
)
def test_a_mapping_that_cannot_be_meant_is_questioned(text, words, tmp_path):
    with pytest.raises(LogError, match=words):
        mapping(tmp_path, text)


@pytest.mark.parametrize(
    "written",
    [
        lambda row: str(array("d", row)),
        lambda row: repr(np.array(row)),
        lambda row: repr(np.array(row, np.float32)),
        lambda row: str(np.array(row)),
        lambda row: str(tuple(row)),
        lambda row: "[" + "; ".join(map(str, row)) + "]",
    ],
    ids=["array", "repr", "float32", "numpy", "tuple", "semicolons"],
)
def test_lists_in_cells_as_python_and_numpy_write_them(written, tmp_path):
    """Nine joints: NumPy goes on in the next line of the file, inside the quotes."""
    values = np.random.default_rng(0).normal(size=(300, 9))
    cells = [written(row.tolist()) for row in values]
    frame = pd.DataFrame({"t": 0.01 * np.arange(300), "position": cells})
    frame.to_csv(tmp_path / "cells.csv", index=False)
    columns = read_delimited(tmp_path / "cells.csv").columns
    assert list(columns) == ["t", *(f"position[{i}]" for i in range(1, 10))]
    read = np.column_stack([columns[f"position[{i}]"] for i in range(1, 10)])
    np.testing.assert_allclose(read, values, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("fields", [1, 2, 3])
def test_a_table_without_header_is_messages_of_joints_where_it_has_their_form(fields, tmp_path):
    rows = [f"5,{10**7 * i},,a,b," + ",".join(str(0.5 * i + j) for j in range(2 * fields)) for i in range(50)]
    (tmp_path / "echo.csv").write_text("\n".join(rows) + "\n")
    read = read_delimited(tmp_path / "echo.csv")
    known = {1: ["position"], 3: ["position", "velocity", "effort"]}.get(fields)
    if known is None:  # velocities or efforts: nobody says
        assert not read.header
        return
    assert list(read.columns) == ["stamp", *(f"{j}.{field}" for field in known for j in ("a", "b"))]
    np.testing.assert_allclose(read.columns["stamp"], 0.01 * np.arange(50), atol=1e-12)
    np.testing.assert_allclose(read.columns["b.position"], 0.5 * np.arange(50) + 1)
