"""Tables lose nothing, at any width."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pyident.verbs.terminal.table import table

WIDTHS = (40, 60, 80, 120)
WORDS = st.text(st.characters(categories=("L", "N", "P", "S")), min_size=1, max_size=30)
CELLS = st.lists(WORDS, max_size=8).map(" ".join)
NAMED = ("stribeck at joint1 or presliding at joint1", "81 %", "-")
VALUES = "order = 200, amplitude[1] = 0.333 ± 0.024 N.m, velocity = 0.01 ± 0.002 rad/s"


@st.composite
def tables(draw: st.DrawFn) -> tuple[list[str], list[list[str]], list[int]]:
    """Heads, rows, columns of numbers."""
    columns = draw(st.integers(1, 7))
    heads = draw(st.lists(CELLS, min_size=columns, max_size=columns))
    rows = draw(st.lists(st.lists(CELLS, min_size=columns, max_size=columns), min_size=1, max_size=6))
    return heads, rows, sorted(draw(st.sets(st.integers(0, columns - 1))))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(given=tables(), width=st.sampled_from(WIDTHS))
def test_every_word_of_every_cell_is_shown(monkeypatch, given, width):
    monkeypatch.setenv("COLUMNS", str(width))
    heads, rows, numbers = given
    shown = table(heads, rows, numbers=numbers)
    for row in rows:
        assert all(word in shown for cell in row for word in cell.split())
        assert all(row[c] in shown for c in numbers)  # a number and its unit stay on one line


@pytest.mark.parametrize("width", WIDTHS)
def test_a_value_keeps_all_its_digits(monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    heads = ("finding", "share of excess", "held out", "parameters")
    shown = table(heads, [(*NAMED, VALUES)], numbers=(1, 2))
    assert max(map(len, shown.splitlines())) <= width
    assert shown.split().count("200,") == 1
    if width >= 80:
        assert "order = 200" in shown
        assert "0.333 ± 0.024 N.m" in " ".join(shown.split())


def test_short_columns_are_not_wrapped_for_the_sake_of_long_ones(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    lines = table(("name", "what"), [("one two three", "word " * 40)]).splitlines()
    assert lines[2].startswith("one two three  word word")
    assert all(line.startswith("word", 15) for line in lines[2:])


def test_what_does_not_fit_is_continued_behind_its_name(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    heads = ["signal", *(f"rmse{n}" for n in range(8))]
    shown = table(heads, [("equation joint1.tau", *(f"{n}.2345678" for n in range(8)))], numbers=range(1, 9))
    assert max(map(len, shown.splitlines())) <= 40
    assert shown.count("joint1.tau") == shown.count("signal") > 1


def test_names_longer_than_the_terminal_stand_in_blocks(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    names = [f"joint{k}.position_dependent_friction.amplitude[{i}]" for k in (1, 2) for i in (1, 2)]
    shown = table(
        ("value", "parameter", "unit"), [("1.2345678", n, "N.m.s2/rad2") for n in names], "log", (0,)
    )
    assert all(shown.splitlines().count(f"  {name}") == 1 for name in names)
    assert shown.startswith("log\nvalue: 1.2345678\nparameter:\n")


def test_characters_that_are_two_columns_wide_are_counted_as_two(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    lines = table(("a", "b"), [("关节", "x"), ("abcd", "x")]).splitlines()
    assert lines[2:] == ["关节  x", "abcd  x"]
