"""The verdict in a word and a sentence."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from one_joint import one_joint
from two_link_logs import two_link

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.notes import of_drifts, of_ends, of_gears, of_mends, of_what_is_shared, warnings
from pyident.diagnosis.result import Finding, Named, Place
from pyident.diagnosis.verdict import asked_for, place_of, sentence_of, separating, verdict_of
from pyident.regression.spectrum import Floor
from pyident.rules.rules import RULES


def _finding(*tie):
    named = tuple(Named(e, j, {}, {}, {}, 97.0) for e, j in tie)
    return Finding(named, 0.05, 50.0, 97.0, 88.0)


def _places(state, before=9.0):
    ratio = (before, 7.0)
    place = SimpleNamespace(joint="joint3", balance="link", state=state, over_floor=ratio, band=None)
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


@pytest.mark.parametrize(
    ("noisy", "said"),
    [
        ({}, "Nothing is missing that these logs could show."),
        ({"joint1": 23.0, "joint2": 37.4}, "could show; 37 % of the torque of joint2 counts as noise."),
        ({"joint2": 130.0}, "logs could show; at joint2 noise is more than the torque, and hides all."),
        ({"joint1": 100.0, "joint2": 480.0}, "These logs could show nothing: what counts as noise is more"),
    ],
)
def test_how_much_counts_as_noise_is_part_of_the_verdict(noisy, said):
    places = _motors("in_order", "in_order", "unobserved")
    assert said in sentence_of("nothing_detectable", (), places, ("joint1", "motor"), noisy=noisy)


def test_what_held_out_data_hardly_show_is_said_to_be_chance():
    sure, weak = (replace(ONE, heldout_std_percent=std) for std in (8.0, 40.0))
    said = [
        sentence_of("missing_effect", [f], _places("in_order"), ("joint2", "motor")) for f in (sure, weak)
    ]
    assert "88 % on held-out data)" in said[0]
    assert "88 ± 40 % on held-out data, which may be chance)" in said[1]


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
    assert rivals.endswith("), these logs cannot tell which.")
    beside = sentence_of("cannot_tell", [RIVALS, ONE, ONE], calm, place)
    assert "), these logs cannot tell which; stribeck at joint2" in beside
    assert beside.count("cannot tell") == 1
    assert "joint2, motor side" in sentence_of("unexplained", [], calm, place)


def test_what_an_inexact_law_leaves_of_much_is_hardly_anything():
    little = _places("unexplained", before=300.0)
    said = sentence_of("missing_effect", [ONE], little, ("joint2", "motor"))
    assert said.endswith(". Of what it lacks hardly anything remains at joint3, link side (7 floors).")


def test_many_findings_are_told_by_law():
    ripples = [_finding(("torque_ripple", f"joint{k}")) for k in (3, 1, 2)]
    said = sentence_of("cannot_tell", [*ripples, ONE, RIVALS], _places("unexplained"), ("joint2", "motor"))
    assert said == (
        "Missing: torque_ripple at joints 1, 2 and 3; stribeck at joint2; "
        "stribeck at joint2 or presliding at joint2, these logs cannot tell which. "
        "Unexplained remains joint3, link side."
    )


def test_the_same_rivals_at_several_joints_are_told_once():
    def rivals(k, first, second):
        asked = f"for {first} at joint {k}: warm up; for {second} at joint {k}: at two speeds"
        return replace(_finding((first, f"joint{k}"), (second, f"joint{k}")), experiment=asked)

    drifts = [rivals(k, *sorted(["viscous", "coulomb"], reverse=k > 2)) for k in (4, 1, 2)]
    listed = [*drifts, ONE, replace(RIVALS, experiment="for a at joint 2: slowly")]
    said = sentence_of("cannot_tell", listed, _places("explained"), ("joint2", "motor"))
    assert said == (
        "Missing: stribeck at joint2; viscous or coulomb at joints 1, 2 and 4, these logs cannot tell which; "
        "stribeck at joint2 or presliding at joint2, these logs cannot tell which."
    )
    warm, slow = separating(listed)
    assert warm == "at joints 1, 2 and 4, for viscous: warm up; for coulomb: at two speeds"
    assert slow == "for a at joint 2: slowly"


def test_sentences_say_where_it_is_left_and_what_the_robot_file_has_wrong():
    place = _places("unexplained")
    place[0].band = (0.5, 1.0, 5.61)
    assert "joint3, link side (5.6 floors from 0.5 to 1 Hz)" in sentence_of(
        "missing_effect", [ONE], place, ("joint2", "motor")
    )
    wrong = Named("origin[z]", "joint3", {"correction": 0.00204}, {}, {"correction": "m"}, 90.0)
    gain = Named("torque_gain", "joint1", {"correction": -0.021}, {}, {"correction": "1"}, 90.0)
    one = replace(_finding(), tie=(wrong,))
    sentence = sentence_of("missing_effect", [one], [], ("joint3", "link"))
    assert sentence.startswith("Wrong: joint3.origin[z] of the robot file by about 0.002 m (97 %")
    both = replace(_finding(), tie=(gain, *ONE.tie))
    sentence = sentence_of("cannot_tell", [both], [], ("joint1", "motor"))
    large = "the gain (torque constant) of joint1, its logged torque is 2.1 % too large"
    assert sentence.startswith(f"Missing or wrong: {large} against the other joints' or stribeck")


@pytest.mark.parametrize(("ratio", "said"), [(0.99, True), (0.1333, True), (0.6, False)])
def test_a_value_at_the_end_of_its_range_is_told(ratio, said):
    spring = Named(
        "gravity_spring", "joint2", {"stiffness": 3.0, "ratio": ratio, "phase": np.pi}, {}, {}, 97.0
    )
    notes = list(of_ends(two_link(), [Finding((spring,), 0.05, 50.0, 97.0, 88.0)]))
    assert [note.split(",")[0] for note in notes] == ["gravity_spring at joint2: its ratio"] * said


@pytest.mark.parametrize(("travel", "said"), [(0.045, True), (0.03, False)])
def test_the_largest_value_that_is_tried_is_an_end_too(travel, said):
    law = Named("presliding", "joint1", {"level": 3.0, "travel": travel}, {}, {}, 97.0)
    assert len(list(of_ends(two_link(), [Finding((law,), 0.05, 50.0, 97.0, 88.0)]))) == said


@pytest.mark.parametrize(("joint", "said"), [("joint2", True), ("joint3", False)])
def test_a_gear_that_drives_with_more_losses_looks_like_a_gain(joint, said):
    found = [_finding(("load_dependent_friction", "joint2")), _finding(("torque_gain", joint))]
    assert [note.split()[0] for note in of_gears(found)] == ["joint2"] * said


@pytest.mark.parametrize("rivals", [("joint2",), ("joint2", "joint3")])
def test_one_of_several_mends_is_told_as_one_that_may_be_it(rivals):
    """Who obeyed both would correct twice."""
    tie = tuple(Named("torque_gain", j, {"correction": 0.06}, {}, {"correction": "1"}, 97.0) for j in rivals)
    told = list(of_mends([Finding(tie, 0.05, 50.0, 97.0, 88.0)]))
    assert [note.split(":")[0] for note in told] == [f"torque_gain at {j}" for j in rivals]
    assert all(("if it is that, multiply" in note) == (len(rivals) > 1) for note in told)


def test_place_and_question_of_a_law():
    robot = two_link()
    stribeck, hardening = Candidate("stribeck", 2), Candidate("hardening_stiffness", 1)
    assert place_of(robot, stribeck) == ("joint2", "motor")
    assert place_of(robot, hardening) == ("joint1", "transmission")
    assert place_of(one_joint(), Candidate("axis[y]", 1)) == ("joint1", "motor")
    assert asked_for(robot, [stribeck]) == ""
    assert asked_for(robot, [stribeck, hardening]).count("at joint") == 2


@pytest.mark.parametrize(
    ("floor", "ratio", "verdict", "said"),
    [
        (99.0, 1.0, "nothing_detectable", ["this says little: replicas leave 99 % of the torque of joint1"]),
        (99.0, 1.0, "missing_effect", []),
        (1.0, 0.1, "missing_effect", ["the residual lies below its floor at joint1, motor side (0.1 times)"]),
        (1.0, 1.0, "nothing_detectable", []),
    ],
)
def test_what_makes_a_verdict_worth_less_is_said(floor, ratio, verdict, said):
    spectrum = Floor(np.linspace(0.1, 20.0, 200), np.ones((1, 200)))
    ex = SimpleNamespace(floor=spectrum, setting=SimpleNamespace(unfollowed=""))
    search = cast(Any, SimpleNamespace(rules=RULES.search, examination=ex))
    place = SimpleNamespace(
        joint="joint1", balance="motor", state="in_order", floor_percent=floor, over_floor=(ratio, ratio)
    )
    found = list(warnings(search, verdict, cast(Any, [place])))
    assert len(found) == len(said)
    assert all(warning.startswith(words) for warning, words in zip(found, said, strict=True))


def test_what_lowers_a_floor_depends_on_where_it_lies():
    frequency = np.linspace(0.1, 20.0, 200)
    place = SimpleNamespace(
        joint="joint1", balance="motor", state="in_order", floor_percent=37.0, over_floor=(1.0, 1.0)
    )
    for rms, said in ((np.ones(200), "finer encoders"), (1 / frequency, "Hz, as of hands, wind")):
        ex = SimpleNamespace(floor=Floor(frequency, rms[None]), setting=SimpleNamespace(unfollowed=""))
        search = cast(Any, SimpleNamespace(rules=RULES.search, examination=ex))
        (warning,) = warnings(search, "nothing_detectable", cast(Any, [place]))
        assert said in warning


def test_a_share_without_held_out_logs_is_said_alone():
    one = cast(Any, SimpleNamespace(**vars(ONE) | {"heldout_gain_percent": None}))
    sentence = sentence_of("missing_effect", [one], _places("in_order"), ("joint2", "motor"))
    assert sentence == "Missing: stribeck at joint2 (97 % of what exceeds the floor there)."


def _motors(*states, after=3.0):
    return [Place(f"joint{k}", "motor", state, (3.0, after), 1.0) for k, state in enumerate(states, start=1)]


def test_no_cause_in_common_is_suspected_where_findings_take_most():
    assert list(of_what_is_shared(_motors(*["unexplained"] * 6, after=2.0), [])) == []


@pytest.mark.parametrize(
    ("states", "who"),
    [
        (["unexplained"] * 3, "every joint is"),
        (["unexplained"] * 4 + ["explained"] * 2, "4 of 6 joints are"),
        (["unexplained"] * 3 + ["unobserved"], "every joint is"),
        (["unexplained"] * 3 + ["in_order"] * 3, None),
        (["unexplained"] * 2, None),
    ],
)
def test_one_cause_is_suspected_where_most_joints_are_left(states, who):
    plain, beside = (list(of_what_is_shared(_motors(*states), f)) for f in ((), [_finding(("stribeck", 1))]))
    assert [note.startswith(f"{who} left unexplained") for note in plain] == [True] * (who is not None)
    assert [note.endswith("only stand in for it") for note in plain] == [False] * (who is not None)
    assert [note.endswith("only stand in for it") for note in beside] == [True] * (who is not None)


def test_drifts_at_many_joints_have_one_cause_that_is_asked_first():
    drifts = [_finding((name, k)) for k in (1, 2, 3) for name in ("coulomb_drift", "offset_drift")]
    (note,) = of_drifts(drifts)
    assert note.startswith("6 drifts at 3 joints: suspect first what they share, as a supply, or torque")
    assert list(of_drifts([*drifts[:4], _finding(("stribeck", 3))])) == []
