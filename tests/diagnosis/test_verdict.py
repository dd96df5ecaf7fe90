"""The verdict in a word and a sentence."""

from types import SimpleNamespace
from typing import Any, cast

import pytest
from two_link_logs import two_link

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.verdict import asked_for, place_of, sentence_of, verdict_of


def _finding(*tie):
    named = [SimpleNamespace(effect=e, joint=j) for e, j in tie]
    return cast(Any, SimpleNamespace(tie=named, share_percent=97.0, heldout_gain_percent=88.0))


def _places(state):
    place = SimpleNamespace(joint="joint3", balance="link", state=state, over_floor=(9.0, 7.0))
    return cast(Any, [place])


ONE = _finding(("stribeck", "joint2"))
RIVALS = _finding(("stribeck", "joint2"), ("presliding", "joint2"))


@pytest.mark.parametrize(
    ("findings", "stands_out", "word"),
    [
        ([], False, "nothing_detectable"),
        ([], True, "unexplained"),
        ([ONE], True, "missing_effect"),
        ([ONE, RIVALS], True, "cannot_tell"),
    ],
)
def test_word(findings, stands_out, word):
    assert verdict_of(findings, stands_out) == word


def test_sentences_name_what_they_mean():
    place, calm = ("joint2", "motor"), _places("in_order")
    sentence = sentence_of("missing_effect", [ONE], calm, place)
    assert "stribeck at joint2 (97 % of what exceeds the floor there, 88 % on held-out data)" in sentence
    assert "nexplained" not in sentence
    rest = sentence_of("missing_effect", [ONE], _places("unexplained"), place)
    assert "Unexplained remains joint3, link side (7 floors)" in rest
    three = sentence_of("missing_effect", [ONE, ONE, ONE], calm, place)
    assert three.count("; stribeck at joint2") == 2
    rivals = sentence_of("cannot_tell", [RIVALS], calm, place)
    assert "or presliding" in rivals
    assert "cannot tell which" in rivals
    assert "joint2, motor side" in sentence_of("unexplained", [], calm, place)


def test_place_and_question_of_a_law():
    robot = two_link()
    stribeck, hardening = Candidate("stribeck", 2), Candidate("hardening_stiffness", 1)
    assert place_of(robot, stribeck) == ("joint2", "motor")
    assert place_of(robot, hardening) == ("joint1", "transmission")
    assert asked_for(robot, [stribeck]) == ""
    assert asked_for(robot, [stribeck, hardening]).count("at joint") == 2
