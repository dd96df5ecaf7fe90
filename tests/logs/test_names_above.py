"""The line of names above a table, where it has more or fewer cells than the rows."""

import io

import numpy as np
import pytest

from pyident.logs.formats.delimited import read_delimited

TIME = np.arange(60) * 0.01
TABLE = np.column_stack([TIME, np.sin(TIME), -TIME])


def read(folder, text, header=True):
    (folder / "raw.txt").write_text(text)
    return read_delimited(folder / "raw.txt", header)


def rows(separator=",", begin="", end=""):
    lines = (separator.join(f"{x:.6g}" for x in row) for row in TABLE)
    return "".join(f"{begin.format(i)}{line}{end}\n" for i, line in enumerate(lines))


@pytest.mark.parametrize("mark", ["# ", "% ", "#", "// "])
@pytest.mark.parametrize("units", ["", "s rad N.m"])
def test_a_comment_mark_is_no_name(mark, units, tmp_path):
    text = io.StringIO()
    head = "time q1 tau1" + (f"\n{units}" if units else "")
    np.savetxt(text, TABLE, header=head, comments=mark)
    found = read(tmp_path, text.getvalue())
    assert list(found.columns) == ["time", "q1", "tau1"]
    assert found.columns["q1"] == pytest.approx(np.sin(TIME))
    assert found.units == (dict(zip(found.columns, units.split(), strict=True)) if units else {})
    assert found.notes == ()


@pytest.mark.parametrize("units", ["", "s,rad,N.m\n"])
def test_a_column_that_counts_the_rows_may_have_no_name(units, tmp_path):
    found = read(tmp_path, f"time,q1,tau1\n{units}{rows(begin='{},')}")
    assert list(found.columns) == ["index", "time", "q1", "tau1"]
    assert found.columns["tau1"] == pytest.approx(-TIME)
    assert found.units.get("q1") == ("rad" if units else None)
    assert found.notes == ("the first column, which counts the rows and has no name, is called index",)


@pytest.mark.parametrize(("name_end", "row_end"), [("", ","), (",", "")])
def test_a_separator_at_the_end_is_no_column(name_end, row_end, tmp_path):
    found = read(tmp_path, f"time,q1,tau1{name_end}\n{rows(end=row_end)}")
    assert list(found.columns) == ["time", "q1", "tau1"]
    assert found.notes == ()


@pytest.mark.parametrize("names", ["time,q1,q2,tau1", "time,q1", "time,q1,q2,tau1,tau2"])
def test_names_that_do_not_fit_are_told(names, tmp_path):
    found = read(tmp_path, f"{names}\n{rows()}")
    assert (list(found.columns), found.header) == (["1", "2", "3"], False)
    count = len(names.split(","))
    assert found.notes == (
        f"there are {count} names above rows of 3 cells: none is used; give as many names as cells",
    )
    assert read(tmp_path, f"{names}\n{rows()}", header=False).notes == ()


def test_columns_in_twos_have_the_names_of_a_list_of_properties(tmp_path):
    """As a scope writes them: a time and a value for each of its channels."""
    text = "Name\tScope\n\nName\tq1\tName\ttau1\nPort\t501\tPort\t501\nVariableSize\t8\tVariableSize\t8\n\n"
    text += "".join(f"{i}\t{t:.6g}\t{i}\t{-t:.6g}\n" for i, t in enumerate(TIME))
    found = read(tmp_path, text)
    assert list(found.columns) == ["q1.time", "q1", "tau1.time", "tau1"]
    assert found.columns["tau1"] == pytest.approx(-TIME)


def test_an_empty_name_of_a_column_that_counts_the_rows_is_index(tmp_path):
    found = read(tmp_path, f",time,q1,tau1\n{rows(begin='{},')}")
    assert list(found.columns) == ["index", "time", "q1", "tau1"]
    assert found.notes == ("the first column, which counts the rows and has no name, is called index",)


def test_lines_that_begin_with_what_they_are_of(tmp_path):
    """As TwinCAT Scope writes them: names, units and numbers that are no rows."""
    labels = {
        "Name": ["ActPos", "ActTorque"],
        "Data-Type": ["REAL64", "INT16"],
        "SampleTime[ms]": ["10", "10"],
        "Unit": ["deg (Angle)", "(None)"],
        "Unit Offset": ["0", "0"],
    }
    above = "\n".join("\t".join([label, *cells]) for label, cells in labels.items())
    begin = "File\tC:\\scope.csv\n\n"
    found = read(tmp_path, f"{begin}{above}\n\n{rows(chr(9))}")
    assert list(found.columns) == ["time", "ActPos", "ActTorque"]
    assert found.columns["ActPos"] == pytest.approx(np.sin(TIME), abs=1e-6)
    assert found.units == {"time": "ms", "ActPos": "deg"}
