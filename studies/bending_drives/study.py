"""Rigid robot files of machines whose drives bend, seen by their motors alone: is that said, and how far?"""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pyident.diagnosis.result import Diagnosis
from pyident.sweep.kept_results import write_json
from pyident.sweep.studies import StudyResult, row

from ..foreign_logs.cases import Case
from ..foreign_logs.kept_cases import solved, written
from ..foreign_logs.methods import Answer, said_of
from ..foreign_logs.scoring import (
    OURS,
    Scored,
    counted,
    findings_right,
    is_alarm,
    is_found,
    is_wrong,
    of_diagnosis,
)
from .logs import DRIVE, EVERY, case_list, made

SEED, CASES = 2501, 48
_TOLD = 0.2  # of a compliance


def run(folder: Path, progress: Callable[[float], None], seed: int = SEED, cases: int = CASES) -> StudyResult:
    """Make, diagnose and count; answers that `folder` has of this seed are kept."""
    listed, where = case_list(seed, cases), folder.absolute() / f"seed_{seed}"
    opened = solved(_solve, listed, where, progress)
    lines = [_line(case, content) for case, content in zip(listed, opened, strict=True)]
    scored = of_diagnosis(listed, opened)
    return StudyResult(table(scored, opened), written(where, lines))


def table(cases: Sequence[Scored], opened: Sequence[dict[str, Any]]) -> list[dict[str, str]]:
    """opened: the cases' files, with the compliances that were told."""
    said = [(c, c.said(OURS)) for c in cases]

    def of(*kinds: str) -> list[tuple[Scored, Answer]]:
        return [(c, a) for c, a in said if c.kind in kinds]

    every, bent = [(t, a) for c, a in of(EVERY) for t in c.truth], of("strong", "medium")
    values = [ratio for content in opened for ratio in _ratios(content)]
    return [
        counted("rigid drives: false alarm", [is_alarm(c, a) for c, a in of("null")], 5, most=True),
        counted("one drive, strong: named", [is_found(c.truth[0], a) for c, a in of("strong")], 95),
        counted("one drive, medium: named", [is_found(c.truth[0], a) for c, a in of("medium")], 80),
        counted("one drive: a wrong name", [is_wrong(c, a) for c, a in bent], 5, most=True),
        counted("two drives: both", [all(is_found(t, a) for t in c.truth) for c, a in of("pair")], 70),
        counted("a drive and a law: both", [all(is_found(t, a) for t in c.truth) for c, a in of("law")], 70),
        counted("every drive of a machine: of all these", [is_found(t, a) for t, a in every]),
        counted("of the compliances told: within 20 %", [abs(r - 1) <= _TOLD for r in values], 90),
        counted("findings with one name: right", findings_right(said, lambda tie: len(tie) == 1)),
        counted("findings in a tie: the truth among them", findings_right(said, lambda tie: len(tie) > 1)),
        row("cases that failed", f"{sum(bool(c.failure) for c in cases)} of {len(cases)}"),
    ]


def _ratios(content: dict[str, Any]) -> list[float]:
    """Compliances that lead their finding, over the true ones."""
    true = {t["names"][0][1]: t["amount"] for t in content["truth"] if t["law"] == DRIVE}
    return [value / true[k] for k, value in content["told"] if k in true]


def _solve(_: None, case: Case, folder: Path) -> None:
    machine = made(case)
    found, said, failure = said_of(machine)
    folder.mkdir(parents=True, exist_ok=True)
    content = {"said": asdict(said), "told": _told(found) if found else [], "failure": failure}
    write_json(folder / f"{case.id}.json", content | machine.sealed)


def _told(found: Diagnosis) -> list[tuple[int, float]]:
    """Joint (from 1) and compliance of every finding that a drive leads."""
    firsts = [f.tie[0] for f in found.findings if f.tie[0].effect == DRIVE]
    return [(int(n.joint.removeprefix("joint")), n.values["correction"]) for n in firsts]


def _line(case: Case, content: dict[str, Any]) -> dict[str, Any]:
    hidden = " + ".join(f"{t['law']}@{t['names'][0][1]} ({t['size']:.1f})" for t in content["truth"])
    said = content["said"]
    ties = " ".join(" or ".join(f"{e}@{k}" for e, k in tie) for tie in said["ties"])
    ratios = " ".join(f"{r:.2f}" for r in _ratios(content))
    return {"id": case.id, "kind": case.kind, "hidden": hidden, "said": said["verdict"], "ties": ties} | {
        "compliance told over true": ratios
    }
