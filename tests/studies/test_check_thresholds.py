"""The study of the checks' thresholds: its variants, one in force, and what it counts."""

import json
from dataclasses import fields, replace

import pytest
from studies.check_thresholds import study
from studies.check_thresholds.study import GROUPS, _difference, run
from studies.half_and_twice.variants import Variant, in_force, variants

from pyident.rules.channel_checks import CHANNELS
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.rule import RulesError


def test_each_threshold_is_halved_and_doubled():
    tried = list(variants(GROUPS))
    assert tried[0] == Variant()
    names = {(group, field.name) for group, rules in GROUPS.items() for field in fields(rules)}
    assert {(variant.group, variant.name) for variant in tried[1:]} == names
    assert len(tried) == len(set(tried)) == 1 + 2 * len(names)


def test_a_threshold_holds_while_it_is_in_force_and_no_longer():
    usual = CHANNELS.many
    with in_force(Variant("channel_checks", "many", "twice"), GROUPS):
        assert CHANNELS.many == 2 * usual
    assert CHANNELS.many == usual
    with in_force(Variant("equation_checks", "band", "half"), GROUPS):
        assert EQUATIONS.band == (0.025, 0.3)
    with in_force(Variant("channel_checks", "few", "half"), GROUPS):
        assert CHANNELS.few == 2  # a whole number
    assert (EQUATIONS.band, CHANNELS.few) == ((0.05, 0.6), 3)


def test_it_is_put_back_after_an_error():
    with pytest.raises(ZeroDivisionError), in_force(Variant("channel_checks", "many", "half"), GROUPS):
        raise ZeroDivisionError
    assert CHANNELS.many == 0.002


def test_what_the_rules_refuse_is_said():
    with pytest.raises(RulesError), in_force(Variant("equation_checks", "energy", "twice"), GROUPS):
        pass


def test_changed_outcomes_are_counted():
    usual = {"wrong": {"a": "refused", "b": "refused", "c": "missed"}, "good": {"d": "missed"}}
    found = {"wrong": {"a": "warned", "b": "warned", "c": "missed"}, "good": {"d": "refused"}}
    assert _difference(usual, usual) == "the same"
    assert _difference(usual, found) == "2 wrong refused to warned, 1 good missed to refused"
    assert _difference(usual, None) == "refused"


@pytest.mark.parametrize("band", [(0.5, 0.2), (0.0, 0.6), (0.1, 1.2)])
def test_a_filter_s_edge_lies_below_the_nyquist_frequency(band):
    with pytest.raises(RulesError, match="it must rise within 0 and 1"):
        replace(EQUATIONS, band=band)


def test_a_second_call_goes_on_with_what_is_there(tmp_path, monkeypatch):
    usual = {"wrong": {"a": "refused"}, "good": {"b": "missed"}}
    flagged = {"wrong": {"a": "refused"}, "good": {"b": "warned"}}
    for variant, outcomes in (("as they are", usual), ("channel_checks.few half", flagged)):
        (tmp_path / f"{variant}.json").write_text(json.dumps(outcomes))
    (tmp_path / "channel_checks.few twice.json").write_text("null")
    monkeypatch.setattr(study, "_outcomes", lambda _: pytest.fail("all is there"))
    shares: list[float] = []
    result = run(tmp_path, shares.append, only=("few",))
    assert result.rows[0]["value"] == "1 of 1 wrong logs flagged, 1 refused; 0 of 1 good ones flagged"
    assert result.rows[1]["what"] == "channel_checks.few = 3"
    assert result.rows[1]["value"] == "half: 1 good missed to warned; twice: refused"
    assert shares[-1] == 1.0
