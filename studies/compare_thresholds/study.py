"""What a comparison would say if its thresholds were half or twice as large.

The cases are those of the study `thresholds`. Each arm is identified and its last log simulated once, with
replicas; for every threshold and factor the residuals alone are judged again.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pyident as pi
from flexmodels.coordinate import joint_number
from pyident.comparison.compare import compared
from pyident.comparison.model_against_replicas import run_trial
from pyident.comparison.trial import on_trial
from pyident.rules.bins import BINS
from pyident.rules.rule import RulesError
from pyident.rules.rules import RULES
from pyident.simulation.fmu_runs import runs_here
from pyident.sweep.studies import StudyResult, row

from ..half_and_twice.answers import answers, reported
from ..half_and_twice.variants import Variant, in_force, variants
from ..rigid_arm.arm import arm
from ..rigid_arm.generator import Case, case_list, logs_of

GROUPS = {"comparison": RULES.comparison, "bins": BINS}
SEED, NULLS = 6007, 3
MADE_ONCE = "replicas"  # their number would have them made again


def run(
    folder: Path, progress: Callable[[float], None], seed: int = SEED, nulls: int = NULLS, most: int = 100
) -> StudyResult:
    """A line per threshold. most: cases. A second call with the same folder goes on with what it lacks."""
    cases = case_list(seed, nulls)[:most]
    found = answers({f"{seed}_{case.id}": case for case in cases}, _said, folder, progress)
    said = {case.id: found[f"{seed}_{case.id}"] for case in cases}
    as_they_are = row(f"as they are, {len(cases)} cases", counted(cases, said, Variant()) or "")
    return reported(folder / "compare_thresholds.csv", as_they_are, _lines(cases, said))


def _variants() -> Iterator[Variant]:
    return (v for v in variants(GROUPS) if v.name != MADE_ONCE)


def counted(cases: list[Case], said: dict[str, Any], variant: Variant) -> str | None:
    """Of how many cases a place was told, and of how many the right one; None: the rules refuse it."""
    found = {case: said[case.id][str(variant)] for case in cases}
    if None in found.values():
        return None
    nulls = [a["joint"] for case, a in found.items() if case.kind == "null"]
    right = [a["joint"] == case.joint for case, a in found.items() if case.kind != "null"]
    whole = sum(a["bumps"] for a in found.values())
    return (
        f"a place in {sum(j is not None for j in nulls)} of {len(nulls)} logs of a sound model, "
        f"the right joint in {sum(right)} of {len(right)} of a wrong one, {whole} bumps"
    )


def _said(case: Case) -> dict[str, Any]:
    """Of a case under every variant; None: the rules refuse it."""
    logs = logs_of(case)
    trial = on_trial(pi.identify(arm(), logs[:-1]).robot, logs[-1:])
    with runs_here(trial.simulated) as workers:
        data, replicas = run_trial(trial, workers, lambda _: None, RULES.comparison.replicas)
    said: dict[str, Any] = {}
    for variant in _variants():
        try:
            with in_force(variant, GROUPS):
                found = compared(trial, data, replicas, RULES.comparison)
                joint = None if found.where is None else joint_number(found.where.coordinate)
                bumps = sum(len(found.bumps(trace)) for trace in found.traces)
                said[str(variant)] = {"joint": joint, "bumps": bumps}
        except RulesError:
            said[str(variant)] = None
    return said


def _lines(cases: list[Case], said: dict[str, Any]) -> Iterator[dict[str, str]]:
    usual = counted(cases, said, Variant())
    for variant in _variants():
        if variant.factor != "half":
            continue
        words = {}
        for factor in ("half", "twice"):
            found = counted(cases, said, Variant(variant.group, variant.name, factor))
            words[factor] = "refused" if found is None else "the same" if found == usual else found
        value = getattr(GROUPS[variant.group], variant.name)
        yield {"threshold": f"{variant.group}.{variant.name} = {value}", **words}
