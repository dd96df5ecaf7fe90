"""The same logs with another filter in the robot file: does the diagnosis say the same?"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched
from pyident.simulation.fmu_runs import runs_here
from pyident.sweep.kept_results import write_json
from pyident.sweep.studies import StudyResult, row

from ..foreign_logs.cases import Case, case_list
from ..foreign_logs.generator import made
from ..foreign_logs.kept_cases import solved, written
from ..foreign_logs.methods import Answer, answer_of
from ..foreign_logs.scoring import Scored, counted, is_alarm, is_found, is_wrong, reopened
from ..foreign_logs.sensors import as_log

SEED, CASES = 2401, 40
NONE = "no filter"
FILTERS: dict[str, dict[str, Any]] = {
    NONE: {},
    "5 Hz": {"cutoff": 5.0},
    "10 Hz, every second sample": {"cutoff": 10.0, "decimate": 2},
    "20 Hz": {"cutoff": 20.0},
    "40 Hz": {"cutoff": 40.0},
}


def run(folder: Path, progress: Callable[[float], None], seed: int = SEED, cases: int = CASES) -> StudyResult:
    """Make, diagnose with every filter and count; answers that `folder` has of this seed are kept."""
    listed, where = case_list(seed, cases), folder.absolute() / f"seed_{seed}"
    opened = solved(_solve, listed, where, progress)
    scored = [
        reopened(case, content["said"], content["failure"], content)
        for case, content in zip(listed, opened, strict=True)
    ]
    lines = [_line(case, content) for case, content in zip(listed, opened, strict=True)]
    return StudyResult(table(scored), written(where, lines))


def table(cases: Sequence[Scored]) -> list[dict[str, str]]:
    """Rows per filter, and of all filters how their findings agree with those without one."""
    rows = []
    for name in FILTERS:
        said = [(c, c.said(name)) for c in cases]
        single = [(c, a) for c, a in said if c.kind in ("strong", "medium")]
        rows += [
            counted(
                f"{name}: false alarm", [is_alarm(c, a) for c, a in said if c.kind == "null"], 10, most=True
            ),
            counted(f"{name}: strong or medium law found", [is_found(c.truth[0], a) for c, a in single]),
            counted(f"{name}: a wrong name", [is_wrong(c, a) for c, a in said], 5, most=True),
        ]
    others = [(c.said(name), c.said(NONE)) for c in cases for name in FILTERS if name != NONE]
    return [
        *rows,
        counted("findings with a filter, also without", [x for a, b in others for x in _also(a, b)], 95),
        counted("findings without, also with a filter", [x for a, b in others for x in _also(b, a)]),
        row("cases that failed", f"{sum(bool(c.failure) for c in cases)} of {len(cases)}"),
    ]


def _also(first: Answer, second: Answer) -> list[bool]:
    """Of each finding of one answer whether the other has one that shares a name with it."""
    return [any(set(tie) & set(other) for other in second.ties) for tie in first.ties]


def _solve(_: None, case: Case, folder: Path) -> None:
    machine, said, failure = made(case), {}, ""
    with threadpool_limits(1):
        for name, changes in FILTERS.items():
            plan = replace(machine.robot.settings.processing, **changes)
            robot = machine.robot.with_settings(processing=plan)
            frames = {"the log to fit": machine.fit, "the log held out": machine.heldout}
            fit, heldout = (as_log(robot, frame, source) for source, frame in frames.items())
            try:
                answer = answer_of(concluded(searched(robot, [fit], runs_here), runs_here, [heldout]))
            except Exception as error:  # a wrong answer, whatever it is
                answer, failure = Answer("failed", []), f"{name}: {type(error).__name__}: {error}"
            said[name] = asdict(answer)
    folder.mkdir(parents=True, exist_ok=True)
    content = {"said": said, "failure": failure}
    write_json(folder / f"{case.id}.json", content | machine.sealed)


def _line(case: Case, content: dict[str, Any]) -> dict[str, Any]:
    laws = " + ".join(
        f"{t['law']}@{t['names'][0][1] if t['names'] else '?'} ({t['size']:.1f})" for t in content["truth"]
    )
    said = {
        name: " ".join([a["verdict"], *(" or ".join(f"{e}@{k}" for e, k in tie) for tie in a["ties"])])
        for name, a in content["said"].items()
    }
    return {"id": case.id, "kind": case.kind, "hidden": laws} | said
