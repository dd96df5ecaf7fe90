"""The summary of a table whose numbers are plain."""

import pandas as pd
import pytest

from pyident.sweep.summary import failures, result_names, summary

TABLE = pd.DataFrame(
    {
        "k": [1.0, 2.0, 3.0, 4.0],
        "tip_error": [0.4, 0.1, 0.3, None],
        "seconds": [1.0, 1.0, 1.0, 1.0],
        "failure": ["", "", "", "the step became too small"],
    }
)


def test_results_are_neither_parameters_nor_of_the_run():
    assert result_names(TABLE, ["k"]) == ["tip_error"]


def test_spread_leaves_failed_runs_out():
    found = summary(TABLE, ["k"]).loc["tip_error"]
    assert found.to_list() == pytest.approx([0.1, 0.3, 0.4])


def test_failures_are_counted_with_their_reason():
    assert failures(TABLE) == ["1 of 4 runs failed: the step became too small"]
    assert failures(TABLE.iloc[:3]) == []
