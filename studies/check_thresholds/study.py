"""What the checks of a log would say if each threshold of channels and equations were half or twice as large.

Every kind of wrong log of `log_checks` is made of one sound log, of another robot for each kind in turn. The
good ones are those that thresholds were fixed on; logs that judge the checks there are not looked at.
"""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import as_completed
from contextlib import nullcontext
from dataclasses import asdict, replace
from itertools import cycle
from pathlib import Path
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits

from flexmodels.atomic import replacing
from pyident.rules.channel_checks import CHANNELS
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.rule import RulesError
from pyident.simulation.processes.workers import workers_with
from pyident.sweep.studies import StudyResult, row

from ..log_checks.good_logs import good_logs
from ..log_checks.study import outcome, sound_bases
from ..log_checks.wrong_logs import KINDS
from .variants import Variant, in_force, variants

GROUPS = {"channel_checks": CHANNELS, "equation_checks": EQUATIONS}


def run(folder: Path, progress: Callable[[float], None], only: tuple[str, ...] = ()) -> StudyResult:
    """A line per threshold. only: names of thresholds; a second call goes on with what it lacks."""
    folder.mkdir(parents=True, exist_ok=True)
    tried = [v for v in variants(GROUPS) if not v.name or not only or v.name in only]
    with workers_with(nullcontext) as workers:
        jobs = [workers.submit(_scored, v, folder / f"{v}.json") for v in tried]
        for number, job in enumerate(as_completed(jobs), start=1):
            job.result()
            progress(number / len(jobs))
    said = {v: json.loads((folder / f"{v}.json").read_text()) for v in tried}
    usual = said[Variant()]
    table = pd.DataFrame(_lines(said, usual))
    with replacing(folder / "check_thresholds.csv") as file:
        table.to_csv(file, index=False)
    rows = [row("as they are", _counted(usual))]
    rows += [
        row(f"{v['threshold']} = {v['value']}", f"half: {v['half']}; twice: {v['twice']}")
        for v in table.to_dict("records")
    ]
    return StudyResult(rows, [folder / "check_thresholds.csv"])


def _scored(_: None, variant: Variant, file: Path) -> None:
    """Outcome of every log, written to `file` unless it is there; null: the rules refuse the value."""
    if file.exists():
        return
    try:
        with threadpool_limits(1), in_force(variant, GROUPS):
            said = {kind: dict(_outcomes(kind)) for kind in ("wrong", "good")}
    except RulesError:
        said = None
    with replacing(file) as path:
        path.write_text(json.dumps(said))


def _outcomes(kind: str) -> Iterator[tuple[str, str]]:
    """Name of a log, and refused, warned or missed."""
    if kind == "good":
        for name, robot, log in good_logs():
            yield name, outcome(robot, log.frame, log.source)[0]
        return
    for (name, change), (robot, log) in zip(KINDS.items(), cycle(sound_bases()), strict=False):
        frame = change(robot, log.frame.copy())
        if frame is not None:
            yield f"{name}, {robot.name}", outcome(robot, frame, "log.csv")[0]


def _counted(said: dict[str, dict[str, str]]) -> str:
    wrong, good = (list(said[kind].values()) for kind in ("wrong", "good"))
    return (
        f"{len(wrong) - wrong.count('missed')} of {len(wrong)} wrong logs flagged, "
        f"{wrong.count('refused')} refused; "
        f"{len(good) - good.count('missed')} of {len(good)} good ones flagged"
    )


def _lines(said: dict[Variant, Any], usual: dict[str, dict[str, str]]) -> Iterator[dict[str, str]]:
    for variant, found in said.items():
        if variant.factor == "half":
            twice = said[replace(variant, factor="twice")]
            rules = GROUPS[variant.group]
            yield {
                "threshold": f"{variant.group}.{variant.name}",
                "value": str(asdict(rules)[variant.name]),
                "half": _difference(usual, found),
                "twice": _difference(usual, twice),
            }


def _difference(usual: dict[str, dict[str, str]], found: dict[str, dict[str, str]] | None) -> str:
    """How many logs of a kind have another outcome, from and to."""
    if found is None:
        return "refused"
    changes: dict[str, int] = {}
    for kind, outcomes in usual.items():
        for name, was in outcomes.items():
            now = found[kind].get(name, "not made")
            if now != was:
                words = f"{kind} {was} to {now}"
                changes[words] = changes.get(words, 0) + 1
    return ", ".join(f"{n} {words}" for words, n in changes.items()) or "the same"
