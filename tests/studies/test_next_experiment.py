"""What the study of designed motions counts."""

import numpy as np
import pandas as pd
from pyident.sweep.studies.next_experiment import study  # pyright: ignore[reportMissingImports]


def table(**columns) -> pd.DataFrame:
    whole = {
        "case": ["a", "b", "c", "d", "e"],
        "promised": [10.0, 60.0, 30.0, 4.0, np.nan],
        "achieved": [11.9, 47.0, 30.0, 4.0, np.nan],
        "best_variant": [5.0, 10.0, 5.0, 4.0, np.nan],
        "named_before": ["in a tie", "alone", "the other", "not named", ""],
        "named_after": ["alone", "alone", "the other", "in a tie", ""],
        "failure": ["", "", "", "", "no motion keeps its limits"],
    }
    return pd.DataFrame(whole | columns)


def test_shares_are_those_of_the_cases_that_ran():
    rows = {row["what"]: (row["value"], row["met"]) for row in study.rows(table())}
    assert rows["motions designed"] == ("4 of 5", "no")
    assert rows["over the best variant, median"] == ("3.54", "no")  # of 2.38, 4.7, 6 and 1
    assert rows["over the best variant, least"][0] == "1"
    assert rows["achieved within 20 % of the promise"] == ("3 of 4", "no")
    assert rows["told apart by 5 deviations"] == ("3 of 4", "no")
    assert rows["law named alone, from the experiment"][0] == "1 of 4"
    assert rows["law named alone, with the designed motion"] == ("2 of 4", "no")


def test_nothing_designed_is_nothing_met():
    (only,) = study.rows(table(failure=["no"] * 5))
    assert (only["value"], only["met"]) == ("0", "no")


def test_pairs_are_drawn_at_one_joint_of_known_sizes(four_link):
    cases = list(study.drawn(four_link, 3))
    again = list(study.drawn(four_link, 3))
    assert [case.name for case in cases] == [case.name for case in again]
    for case in cases:
        one, other = case.pair
        assert one.effect != other.effect
        assert one.joint == other.joint
        assert one.size
        assert other.size
