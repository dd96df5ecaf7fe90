"""What a comparison would say if its thresholds were half or twice as large.

The cases are those of the study `thresholds`. Each arm is identified and its last log simulated once, with
replicas; for every threshold and factor the residuals alone are judged again.
"""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import as_completed
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits

import pyident as pi
from flexmodels.atomic import replacing
from flexmodels.coordinate import joint_number
from pyident.comparison.compare import compared
from pyident.comparison.model_against_replicas import on_trial, run_trial
from pyident.rules.bins import BINS
from pyident.rules.rule import RulesError
from pyident.rules.rules import RULES
from pyident.simulation.fmu_runs import runs_here
from pyident.simulation.processes.workers import workers_with
from pyident.sweep.studies import StudyResult, row

from ..check_thresholds.variants import Variant, in_force, variants
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
    folder.mkdir(parents=True, exist_ok=True)
    with workers_with(nullcontext) as workers:
        jobs = [workers.submit(_answered, case, folder / f"{seed}_{case.id}.json") for case in cases]
        for number, job in enumerate(as_completed(jobs), start=1):
            job.result()
            progress(number / len(cases))
    said = {case.id: json.loads((folder / f"{seed}_{case.id}.json").read_text()) for case in cases}
    table = pd.DataFrame(_lines(cases, said))
    with replacing(folder / "compare_thresholds.csv") as file:
        table.to_csv(file, index=False)
    rows = [row(f"as they are, {len(cases)} cases", counted(cases, said, Variant()) or "")]
    rows += [row(v["threshold"], f"half: {v['half']}; twice: {v['twice']}") for v in table.to_dict("records")]
    return StudyResult(rows, [folder / "compare_thresholds.csv"])


def _variants() -> Iterator[Variant]:
    return (v for v in variants(GROUPS) if v.name != MADE_ONCE)


def counted(cases: list[Case], said: dict[str, Any], variant: Variant) -> str | None:
    """Of how many cases a place was told, and of how many the right one; None: the rules refuse it."""
    answers = {case: said[case.id][str(variant)] for case in cases}
    if None in answers.values():
        return None
    nulls = [a["joint"] for case, a in answers.items() if case.kind == "null"]
    right = [a["joint"] == case.joint for case, a in answers.items() if case.kind != "null"]
    whole = sum(a["bumps"] for a in answers.values())
    return (
        f"a place in {sum(j is not None for j in nulls)} of {len(nulls)} logs of a sound model, "
        f"the right joint in {sum(right)} of {len(right)} of a wrong one, {whole} bumps"
    )


def _answered(_: None, case: Case, file: Path) -> None:
    """What is said of a case under every variant, written to `file` unless it is there."""
    if file.exists():
        return
    with threadpool_limits(1):
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
                    said[str(variant)] = {
                        "joint": joint,
                        "bumps": sum(len(found.bumps(trace)) for trace in found.traces),
                    }
            except RulesError:
                said[str(variant)] = None
    with replacing(file) as path:
        path.write_text(json.dumps(said))


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
