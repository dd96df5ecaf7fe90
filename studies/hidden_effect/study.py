"""Robots that hide an effect, made by an independent generator: how often is the diagnosis right?"""

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexmodels.atomic import replacing
from pyident.rules.rules import RULES
from pyident.sweep.studies import StudyResult

from .blind import ROBOT, solve_all
from .confusion import confusion, figure
from .generator.cases import Case
from .generator.logs_and_key import case_list
from .scoring import Scored, score, table, unseal

Progress = Callable[[float], None]
SEED, TUNING = 2141, 11  # what is scored, and one of those (11, 2026 to 2131) on which rules were chosen


@dataclass(frozen=True)
class Plan:
    """most: of each kind of case; None: all. nulls: of the full list."""

    seed: int = SEED
    nulls: int = 12
    most: Mapping[str, int] | None = None
    replicas: int = RULES.replicas.count

    def cases(self) -> list[Case]:
        listed = case_list(self.seed, ROBOT, self.nulls)
        if self.most is None:
            return listed
        kinds = [c.kind for c in listed]
        return [c for i, c in enumerate(listed) if kinds[:i].count(c.kind) < self.most.get(c.kind, 0)]


REDUCED = Plan(TUNING, 12, {"null": 2, "single": 3, "outside": 1, "unobservable": 1}, replicas=19)


def run(folder: Path, progress: Progress, plan: Plan | None = None, seed: int = SEED) -> StudyResult:
    """Make, diagnose and score the cases of a plan; none: all of `seed`.

    Few of them where PYIDENT_HIDDEN_EFFECT=reduced.
    """
    if plan is None:
        plan = REDUCED if os.environ.get("PYIDENT_HIDDEN_EFFECT") == "reduced" else Plan(seed)
    cases = plan.cases()
    solve_all(cases, folder, plan.replicas, progress)
    return report([unseal(folder, case.id) for case in cases], folder)


def report(cases: list[Scored], folder: Path) -> StudyResult:
    """Score table; cases.csv, confusion.csv and confusion.png in `folder`."""
    kinds = ("null", "single", "pair", "outside", "unobservable", "unknown")
    ordered = sorted(cases, key=lambda c: (kinds.index(c.kind), c.truth, c.id))
    listed, counts = table(ordered), confusion(ordered)
    paths = [folder / name for name in ("cases.csv", "confusion.csv", "confusion.png")]
    with replacing(paths[0]) as file:
        listed.to_csv(file, index=False)
    with replacing(paths[1]) as file:
        counts.to_csv(file)
    figure(counts).savefig(paths[2], dpi=130)
    return StudyResult(score(ordered), paths, [_line(line) for line in listed.to_dict("records")])


def _line(row: Mapping[Any, Any]) -> str:
    share = "" if math.isnan(row["share"]) else f"{row['share']:.2f} of the achievable fall, "
    said = row["failure"] or f"{row['verdict']} {row['names']}"
    return (
        f"{row['id']} {row['kind']:<12} {row['truth'] or '-':<48} -> {said} ({share}{row['seconds']:.0f} s)"
    )
