"""Logs that others would bring, of machines drawn at random: what is said of them?"""

import json
import time
from collections.abc import Callable, Mapping
from concurrent.futures import as_completed
from contextlib import nullcontext
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits

from flexmodels.atomic import replacing
from flexmodels.files.robot_file import save_robot
from flexmodels.robot import RobotError
from pyident.simulation.processes.workers import workers_with
from pyident.sweep.kept_results import write_json
from pyident.sweep.studies import StudyResult

from .cases import Case, case_list
from .generator import made
from .methods import Method, all_answers, named
from .scoring import Scored, reopened, table
from .sensors import as_log

SEED, CASES = 2050, 120
MISSING = "Pinocchio (package pin) is missing, which makes this study's logs; pip install 'flexident[bench]'"


def run(
    folder: Path,
    progress: Callable[[float], None],
    seed: int = SEED,
    cases: int = CASES,
    methods: Mapping[str, Method] | None = None,
    joints: int = 7,
) -> StudyResult:
    """Make, diagnose and count; answers that `folder` has of this seed are kept.

    methods   your own by name, beside the diagnosis and the simpler ones; importable functions
    joints    of the largest machine
    """
    if find_spec("pinocchio") is None:
        raise RobotError(MISSING)
    listed, own = case_list(seed, cases), dict(methods or {})
    where = folder.absolute() / f"seed_{seed}_joints_{joints}"
    left = [c for c in listed if not _answered(where, c, own)]
    progress(1 - len(left) / len(listed))
    with workers_with(nullcontext) as workers:
        jobs = [workers.submit(_solve, case, where, own, joints) for case in left]
        for count, job in enumerate(as_completed(jobs), start=1):
            job.result()
            progress(1 - (len(left) - count) / len(listed))
    return report(where, listed)


def report(folder: Path, cases: list[Case]) -> StudyResult:
    """The table, and cases.csv with a line per case."""
    scored = {case.id: _read(folder, case) for case in cases}
    names = list(dict.fromkeys(name for s in scored.values() for name in s.answers))
    lines = [_line(case, scored[case.id]) for case in cases]
    with replacing(folder / "cases.csv") as file:
        pd.DataFrame(lines).to_csv(file, index=False)
    return StudyResult(table(list(scored.values()), names), [folder / "cases.csv"])


def _solve(_: None, case: Case, folder: Path, own: Mapping[str, Method], joints: int) -> None:
    """Answers are on the disk before the truth is."""
    begin, machine = time.perf_counter(), made(case, joints)
    logs = folder / "logs" / case.id
    logs.mkdir(parents=True, exist_ok=True)
    save_robot(machine.robot, logs / "robot.toml")
    machine.fit.to_parquet(logs / "fit.parquet")
    machine.heldout.to_parquet(logs / "heldout.parquet")
    fit = [as_log(machine.robot, machine.fit, "the log to fit")]
    heldout = [as_log(machine.robot, machine.heldout, "the log held out")]
    said: dict[str, Any] = {"answers": {}, "failure": "", "joints": len(machine.robot.joints)}
    with threadpool_limits(1):
        try:
            answers = all_answers(machine.robot, fit, heldout)
            answers |= {name: named(method(machine.robot, fit, heldout)) for name, method in own.items()}
            said["answers"] = {name: asdict(answer) for name, answer in answers.items()}
        except Exception as error:  # a wrong answer, whatever it is
            said["failure"] = f"{type(error).__name__}: {error}"
    write_json(folder / "answers" / f"{case.id}.json", said | {"seconds": time.perf_counter() - begin})
    write_json(folder / "sealed" / f"{case.id}.json", machine.sealed)


def _answered(folder: Path, case: Case, own: Mapping[str, Method]) -> bool:
    said, sealed = (folder / part / f"{case.id}.json" for part in ("answers", "sealed"))
    if not (said.is_file() and sealed.is_file()):
        return False
    content = json.loads(said.read_text(encoding="utf-8"))
    return bool(content["failure"]) or set(own) <= set(content["answers"])


def _read(folder: Path, case: Case) -> Scored:
    said = json.loads((folder / "answers" / f"{case.id}.json").read_text(encoding="utf-8"))
    sealed = json.loads((folder / "sealed" / f"{case.id}.json").read_text(encoding="utf-8"))
    return reopened(case, said["answers"], said["failure"], sealed)


def _line(case: Case, scored: Scored) -> dict[str, Any]:
    hidden = " + ".join(f"{t.law}@{t.names[0][1] if t.names else '?'} ({t.size:.1f})" for t in scored.truth)
    said = {
        name: " ".join([a.verdict, *(" or ".join(f"{e}@{k}" for e, k in tie) for tie in a.ties)])
        for name, a in scored.answers.items()
    }
    drawn = {k: v for k, v in asdict(case).items() if k != "seed"}
    return drawn | {"hidden": hidden} | said | {"failure": scored.failure}
