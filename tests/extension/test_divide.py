"""Logs in which the last link becomes another."""

import numpy as np
import pandas as pd
import pytest

from pyident.checks.defect import Defect
from pyident.extension.divide import divided, instants
from pyident.logs.log import Log

TIME = 1.7e9 + 0.01 * np.arange(1000)


def log(source: str) -> Log:
    return Log(pd.DataFrame({"time": TIME, "joint1.e": np.sin(TIME)}), source)


def change(source: str, after: float) -> Defect:
    return Defect("doubtful", "change", "", f"{source}: ...", (source, TIME[0] + after))


def test_a_log_is_two_where_its_last_link_changes():
    other = Defect("doubtful", "delay", "", "b.csv: ...")
    logs = [log("a.csv"), log("b.csv")]
    found, said = divided(logs, instants(logs, [other, change("a.csv", 4.0)]))
    assert [part.source for part in found] == [
        "a.csv before 1700000004 s",
        "a.csv from 1700000004 s on",
        "b.csv",
    ]
    assert [len(part) for part in found] == [400, 600, 1000]
    assert found[1].after == pytest.approx(4.0)
    assert found[1].began == pytest.approx(TIME[0])
    assert said == ("a.csv counts as two logs, before and from 1700000004 s on: the last link changes there",)


def test_a_log_is_whole_where_a_part_would_be_short():
    found, said = divided([log("a.csv")], instants([log("a.csv")], [change("a.csv", 0.5)]))
    assert [part.source for part in found] == ["a.csv"]
    assert said == ()


def test_logs_of_one_name_are_not_taken_for_each_other():
    """Data frames are all called so."""
    frames = [log("the data frame"), log("the data frame")]
    assert instants(frames, [change("the data frame", 4.0)]) == {}


def test_machines_are_not_told_of_the_log_apart():
    assert "another_body" not in change("a.csv", 1.0).json()
