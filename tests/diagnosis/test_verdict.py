"""The verdict in a word and a sentence."""

from types import SimpleNamespace
from typing import Any, cast

import pytest
from two_link_logs import two_link

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.verdict import asked_for, place_of, sentence_of, verdict_of


def _finding(*tie):
    return cast(Any, SimpleNamespace(tie=[SimpleNamespace(effect=e, joint=j) for e, j in tie]))


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
    place = ("joint2", "motor")
    assert "stribeck at joint2" in sentence_of("missing_effect", [ONE], 0.97, place)
    assert "97 %" in sentence_of("missing_effect", [ONE], 0.97, place)
    assert "the rest is unexplained" in sentence_of("missing_effect", [ONE], 0.6, place)
    assert "or presliding" in sentence_of("cannot_tell", [RIVALS], 0.97, place)
    assert "joint2, motor side" in sentence_of("unexplained", [], 0.0, place)


def test_place_and_question_of_a_law():
    robot = two_link()
    stribeck, hardening = Candidate("stribeck", 2), Candidate("hardening_stiffness", 1)
    assert place_of(robot, stribeck) == ("joint2", "motor")
    assert place_of(robot, hardening) == ("joint1", "transmission")
    assert asked_for(robot, [stribeck]) == ""
    assert asked_for(robot, [stribeck, hardening]).count("at joint") == 2
