"""One case of the study: make its logs, diagnose them from the open folder, then break the seal."""

import json
import time
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from contextlib import nullcontext
from dataclasses import asdict, replace
from pathlib import Path

from threadpoolctl import threadpool_limits

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.search.held_out import held_out
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log, read_log
from pyident.rules.rules import RULES, Rules
from pyident.simulation.fmu_runs import runs_here
from pyident.simulation.processes.workers import workers_with
from pyident.sweep.code_version import code_version
from pyident.sweep.kept_results import keep, kept, write_json
from pyident.verbs.inputs import Given

from .generator.cases import LOGS, Case
from .generator.logs_and_key import generate
from .oracle import Bound, bound

ROBOT = "four_link"
_OWN = ("blind.py", "oracle.py", "generator/*.py")

Reader = Callable[[Path, Robot], Given]


def _as_logged(folder: Path, robot: Robot) -> Given:
    """All that was logged, taken as it is."""
    logs = tuple(read_log(folder / f"{name}.parquet") for name in LOGS)
    return Given(robot, logs[:2], logs[2:], (), ())


def solve_all(
    cases: Sequence[Case],
    folder: Path,
    replicas: int,
    progress: Callable[[float], None],
    robot: str = ROBOT,
    read: Reader = _as_logged,
) -> None:
    """Every case that `folder` does not hold yet, one per core; after an interrupt the same call goes on.

    robot   the plain one that the cases were drawn from: shipped, or a file
    read    what the diagnosis gets to see of a case's logs
    Writes per case logs/<id>, diagnosed/<id>.json and, sealed, sealed/<id>/key.json and oracle.json.
    """
    own = [file for pattern in _OWN for file in Path(__file__).parent.glob(pattern)]
    of = code_version(f"{robot} {replicas} {read.__qualname__}", own)
    left = [case for case in cases if not _finished(case.id, folder, of)]
    progress(1 - len(left) / len(cases))
    with workers_with(nullcontext) as workers:
        jobs = [workers.submit(_solve, case, folder.absolute(), robot, replicas, read, of) for case in left]
        for i, job in enumerate(as_completed(jobs)):
            job.result()
            progress(1 - (len(left) - i - 1) / len(cases))


def _solve(_: None, case: Case, folder: Path, robot: str, replicas: int, read: Reader, of: str) -> None:
    with threadpool_limits(1):
        try:
            _unseen(case, folder, robot, replicas, read, of)
        except Exception as error:
            failure = f"{type(error).__name__}: {error}"
            write_json(folder / "diagnosed" / f"{case.id}.json", {"failure": failure})


def _unseen(case: Case, folder: Path, robot: str, replicas: int, read: Reader, of: str) -> None:
    """The diagnosis is on the disk before the key is read."""
    begin, sealed = time.perf_counter(), folder / "sealed" / case.id
    generate(case, folder)
    seen = read(folder / "logs" / case.id, load_robot(robot))
    search, found = _diagnosed(seen, replicas)
    said = {"seconds": time.perf_counter() - begin, "diagnosis": found.json()}
    keep(folder / "diagnosed" / f"{case.id}.json", of, said)
    best = _bound(search, found, seen.heldout, sealed / "key.json")
    keep(sealed / "oracle.json", of, asdict(best) if best else {})


def _diagnosed(seen: Given, replicas: int) -> tuple[Search, Diagnosis]:
    """The diagnosis of an open folder's logs, and what it rests on; nothing else is known here."""
    search = searched(seen.robot, seen.logs, runs_here, rules=_rules(replicas))
    found = concluded(search, runs_here, seen.heldout)
    return search, replace(found, notes=(*seen.notes, *found.notes))


def notes_of(folder: Path, name: str) -> list[str]:
    """What the diagnosis of a case of `folder` noted; nothing where it failed."""
    said = json.loads((folder / "diagnosed" / f"{name}.json").read_text(encoding="utf-8"))
    return said.get("diagnosis", {}).get("notes", [])


def _bound(search: Search, found: Diagnosis, heldout: Sequence[Log], key: Path) -> Bound | None:
    """What the truth would have reached, where it is in the catalogue and can be seen."""
    read = json.loads(key.read_text(encoding="utf-8"))
    if read["kind"] not in ("single", "pair"):
        return None
    truth = [(law["law"], law["joint"]) for law in read["laws"]]
    return bound(search, found, truth, held_out(search, heldout))


def _rules(replicas: int) -> Rules:
    return replace(RULES, replicas=replace(RULES.replicas, count=replicas))


def _finished(name: str, folder: Path, of: str) -> bool:
    """Whether this very program has done the case to its end."""
    files = folder / "diagnosed" / f"{name}.json", folder / "sealed" / name / "oracle.json"
    return all(kept(file, of) is not None for file in files)
