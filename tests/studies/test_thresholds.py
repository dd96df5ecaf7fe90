"""The study of thresholds: its variants, what it counts, and one case through all of it."""

from studies.rigid_arm.generator import Case
from studies.thresholds.study import Scores, _difference, scores, variants

from pyident.rules.rules import RULES

CASES = [
    Case("n0", "null"),
    Case("s1", "single", "stribeck", 2),
    Case("s2", "single", "torque_ripple", 4),
    Case("o1", "outside", "cable", 3),
]
STRIBECK, RIPPLE, OTHER = ["stribeck", "joint2"], ["torque_ripple", "joint4"], ["payload", "joint6"]


def test_each_threshold_is_halved_and_doubled_alone():
    found = dict(variants())
    assert found["as it is"] == RULES
    half = found["own 0.5"]
    assert half is not None
    assert half.search.own == 0.5 * RULES.search.own
    assert half.search.whole == RULES.search.whole
    assert found["whole 2"] is None  # a share above 1
    assert found["level 0.5"] is None  # more replicas would be needed
    twice = found["explained 2"]
    assert twice is not None
    assert twice.search.explained == (0.8, 1.0, 1.0)


def test_scores_count_what_is_right_and_what_is_further():
    said = {
        "n0": {"verdict": "nothing_detectable", "ties": []},
        "s1": {"verdict": "missing_effect", "ties": [[STRIBECK], [OTHER]]},
        "s2": {"verdict": "cannot_tell", "ties": [[OTHER, RIPPLE]]},
        "o1": {"verdict": "missing_effect", "ties": [[OTHER]]},
    }
    assert scores(CASES, said) == Scores(cleared=1, first=1, tied=2, further=1, outside=1)


def test_a_difference_names_the_scores_that_changed():
    usual = Scores(3, 4, 5, 0, 1)
    assert _difference(usual, usual) == "the same"
    assert _difference(usual, Scores(2, 4, 5, 0, 0)) == "cleared 3 to 2, outside 1 to 0"
