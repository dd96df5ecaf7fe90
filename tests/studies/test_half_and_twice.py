"""Studies that halve and double thresholds of comparisons and of foreign FMUs."""

import json
from typing import Any

from studies.check_thresholds.variants import Variant, variants
from studies.compare_thresholds import study as compared
from studies.greybox_thresholds import study as greybox
from studies.rigid_arm.generator import case_list

from pyident.rules.greybox import GREYBOX
from pyident.rules.rules import RULES


def test_places_are_counted_by_what_was_hidden(tmp_path):
    """Answers written by hand: a null with a place, the right joint, a wrong one, rules that refuse."""
    cases = [c for c in case_list(compared.SEED, 1) if c.kind != "outside"][:3]
    kinds = [c.kind for c in cases]
    assert kinds == ["null", "single", "single"]
    joints = [None, cases[1].joint, cases[2].joint % 6 + 1]
    names = [str(v) for v in variants(compared.GROUPS)]
    for case, joint in zip(cases, joints, strict=True):
        said: dict[str, Any] = {name: {"joint": joint, "bumps": 2} for name in names}
        said["comparison.matters half"] = {"joint": 1, "bumps": 9}
        said["bins.quantiles twice"] = None
        (tmp_path / f"{compared.SEED}_{case.id}.json").write_text(json.dumps(said))
    answers = {c.id: json.loads((tmp_path / f"{compared.SEED}_{c.id}.json").read_text()) for c in cases}
    usual = "a place in 0 of 1 logs of a sound model, the right joint in 1 of 2 of a wrong one, 6 bumps"
    assert compared.counted(cases, answers, Variant()) == usual
    half = compared.counted(cases, answers, Variant("comparison", "matters", "half"))
    assert half is not None
    assert half.startswith("a place in 1 of 1 logs")
    assert half.endswith("27 bumps")
    assert compared.counted(cases, answers, Variant("bins", "quantiles", "twice")) is None
    lines = {line["threshold"]: line for line in compared._lines(cases, answers)}
    assert not any(name.startswith("comparison.replicas") for name in lines)  # they are made once
    matters = lines[f"comparison.matters = {RULES.comparison.matters}"]
    assert (matters["half"], matters["twice"]) == (half, "the same")
    assert next(line for name, line in lines.items() if "quantiles" in name)["twice"] == "refused"


def test_a_drawn_output_is_read_by_the_changed_threshold(tmp_path, monkeypatch):
    """One of each kind: what the rules refuse is said, and they are put back."""
    monkeypatch.setattr(greybox, "LOOKED_AT", ("starts", "tie"))
    usual = (GREYBOX.starts, GREYBOX.tie)
    result = greybox.run(tmp_path, lambda _: None, draws=1)
    assert (GREYBOX.starts, GREYBOX.tie) == usual
    assert "frequency found 1, stair without interval 1" in result.rows[0]["value"]
    assert result.rows[2]["what"] == "greybox.tie = 0.8"
    assert result.rows[2]["value"].endswith("twice: refused")
    assert (tmp_path / "greybox_thresholds.csv").is_file()
