"""What a wrong table is told, place and cure included."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmodels.files.toml_table import Table
from flexmodels.robot import RobotError

TABLE = {"a": {"x": 1.5, "on": True, "v": [1, 2, 3], "n": [{"y": 2}, {"y": "three"}]}}


def test_places_are_paths():
    a = Table(TABLE, "").table("a")
    assert a.number("x") == 1.5
    assert a.flag("on")
    assert a.vector("v", 3) == (1.0, 2.0, 3.0)
    with pytest.raises(RobotError, match=r"^a\.z is missing$"):
        a.get("z")
    with pytest.raises(RobotError, match=r"^a\.X is missing; a\.x is there, and capitals matter$"):
        a.get("X")
    with pytest.raises(RobotError, match=r"^a\.v must be 2 numbers$"):
        a.vector("v", 2)
    with pytest.raises(RobotError, match=r"^a\.n\[2\]\.y must be a finite number, not 'three'"):
        a.tables("n")[1].number("y")
    with pytest.raises(RobotError, match=r"^a\.x must be true or false"):
        a.flag("x")


def test_a_key_that_nobody_asked_for_is_refused():
    table = Table({"known": 1, "unknwon": 2}, "joint[1]")
    table.number("known")
    with pytest.raises(RobotError, match=r"^joint\[1\]\.unknwon is not a known key"):
        table.done()


@given(st.one_of(st.booleans(), st.text(max_size=3), st.none(), st.just(float("nan")), st.just(float("inf"))))
def test_only_finite_numbers_are_numbers(value):
    with pytest.raises(RobotError, match="key"):
        Table({"key": value}, "").number("key", 0.0)


@given(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9))
def test_bounds(value, lower):
    table = Table({"key": value}, "")
    if value >= lower:
        assert table.number("key", lower=lower) == value
    else:
        with pytest.raises(RobotError, match="must be at least"):
            table.number("key", lower=lower)
