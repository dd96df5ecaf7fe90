"""A rigid arm from another simulator, its loop unknown: what is named, and what simpler methods say."""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits

from flexmodels.atomic import replacing
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched
from pyident.simulation.processes.workers import workers_with
from pyident.sweep.kept_results import write_json
from pyident.sweep.studies import StudyResult, row

from .arm import arm
from .baselines import METHODS
from .generator import Case, case_list, logs_of

SEED, NULLS = 4711, 4


@dataclass(frozen=True)
class Answer:
    """verdict; ties: of every finding its names, the best first; others: method -> names."""

    verdict: str
    ties: list[list[tuple[str, int]]]
    others: dict[str, list[tuple[str, int]]]
    seconds: float


def run(folder: Path, progress: Callable[[float], None], seed: int = SEED, nulls: int = NULLS) -> StudyResult:
    """Diagnose every case from its logs alone, then count."""
    cases = case_list(seed, nulls)
    folder.mkdir(parents=True, exist_ok=True)
    answers: dict[str, Answer] = {}
    with workers_with(nullcontext) as workers:
        jobs = {workers.submit(_answered, case): case for case in cases}
        for job in as_completed(jobs):
            case = jobs[job]
            answers[case.id] = job.result()
            said = {"case": asdict(case), "answer": asdict(answers[case.id])}
            write_json(folder / f"{case.id}.json", said)
            progress(len(answers) / len(cases))
    table = pd.DataFrame([_line(case, answers[case.id]) for case in cases])
    with replacing(folder / "cases.csv") as file:
        table.to_csv(file, index=False)
    return StudyResult(_rows(cases, answers), [folder / "cases.csv"])


def _answered(_: None, case: Case) -> Answer:
    with threadpool_limits(1):
        begin, logs = time.perf_counter(), logs_of(case)
        search = searched(arm(), logs[:-1], _never)
        found = concluded(search, _never, logs[-1:])
        ties = [[(n.effect, int(n.joint.removeprefix("joint"))) for n in f.tie] for f in found.findings]
        others = {name: list(method(search)) for name, method in METHODS.items()}
        return Answer(found.verdict, ties, others, time.perf_counter() - begin)


def _never(_: Any) -> Any:
    raise AssertionError("along the measured motion nothing is simulated")


def _line(case: Case, answer: Answer) -> dict[str, Any]:
    said = " + ".join(" or ".join(f"{e}@{k}" for e, k in tie) for tie in answer.ties)
    others = {name: " ".join(f"{e}@{k}" for e, k in names) for name, names in answer.others.items()}
    return asdict(case) | {"verdict": answer.verdict, "names": said, "seconds": answer.seconds} | others


def _rows(cases: Sequence[Case], answers: dict[str, Answer]) -> list[dict[str, str]]:
    rows = []
    of = {kind: [c for c in cases if c.kind == kind] for kind in ("null", "single", "outside")}
    first = {c.id: answers[c.id].ties[0] if answers[c.id].ties else [] for c in cases}
    truth = {c.id: (c.law, c.joint) for c in cases}
    rows.append(
        _share(
            "false alarm with nothing hidden",
            [answers[c.id].verdict != "nothing_detectable" for c in of["null"]],
            "<= 5 %",
        )
    )
    rows.append(
        _share("truth in the first tie", [truth[c.id] in first[c.id] for c in of["single"]], ">= 95 %")
    )
    rows.append(
        _share("truth strictly first", [first[c.id][:1] == [truth[c.id]] for c in of["single"]], ">= 90 %")
    )
    rows.append(
        _share(
            "a finding without the truth",
            [any(truth[c.id] not in t for t in answers[c.id].ties) for c in of["single"]],
            "<= 5 %",
        )
    )
    rows.append(
        _share(
            "outside: confidently wrong",
            [answers[c.id].verdict == "missing_effect" for c in of["outside"]],
            "<= 5 %",
        )
    )
    for name in METHODS:
        named = {c.id: answers[c.id].others[name] for c in cases}
        rows.append(_share(f"{name}: false alarm", [bool(named[c.id]) for c in of["null"]]))
        rows.append(_share(f"{name}: truth first", [named[c.id][:1] == [truth[c.id]] for c in of["single"]]))
        rows.append(
            _share(
                f"{name}: something else named",
                [any(n != truth[c.id] for n in named[c.id]) for c in of["single"]],
            )
        )
        rows.append(_share(f"{name}: outside, a name", [bool(named[c.id]) for c in of["outside"]]))
    return rows


def _share(what: str, hits: Sequence[bool], goal: str = "") -> dict[str, str]:
    if not hits:
        return row(what, "no cases", goal)
    return row(what, f"{100 * sum(hits) / len(hits):.0f} % ({sum(hits)} of {len(hits)})", goal)
