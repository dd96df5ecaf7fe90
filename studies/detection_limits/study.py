"""Are the smallest effects that a diagnosis says it would have named indeed named?"""

from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint
from threadpoolctl import threadpool_limits

from flexmodels.atomic import replacing
from flexmodels.coordinate import joint_number
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, slopes
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.result import Limit
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.denoised import denoised_every_sample
from pyident.simulation.fmu_runs import runs_here
from pyident.simulation.processes.workers import workers_with
from pyident.sweep.studies import StudyResult, row

from ..foreign_logs.cases import Case, case_list
from ..foreign_logs.generator import made
from ..foreign_logs.sensors import as_log

SEED, CASES, LAWS = 2117, 24, 2


@dataclass(frozen=True)
class Injected:
    """A law put into a log in which nothing is hidden, as large as its limit says, and what was said."""

    case: str
    effect: str
    joint: str
    share_percent: float
    named: bool
    sentence: str


def run(
    folder: Path, progress: Callable[[float], None], seed: int = SEED, cases: int = CASES, laws: int = LAWS
) -> StudyResult:
    """cases: logs with nothing hidden, of foreign_logs;  laws: that are put into each, one at a time."""
    listed = [case for case in case_list(seed, 10 * cases) if case.kind == "null"][:cases]
    found: list[Injected] = []
    with workers_with(nullcontext) as workers:
        jobs = [workers.submit(_of_case, case, laws) for case in listed]
        for count, job in enumerate(jobs, start=1):
            found += job.result()
            progress(count / len(jobs))
    with replacing(folder / "detection_limits.csv") as file:
        pd.DataFrame(found).to_csv(file, index=False)
    return StudyResult(_table(found), [folder / "detection_limits.csv"])


def _table(found: list[Injected]) -> list[dict[str, str]]:
    wanted, named, number = "75 to 95 %", sum(x.named for x in found), len(found)
    if not number:
        return [row("named at the stated limit", "no cases", wanted)]
    low, high = proportion_confint(named, number, method="wilson")
    said = f"{named} of {number} (95 %: {100 * low:.0f} to {100 * high:.0f} %)"
    return [row("named at the stated limit", said, wanted, 0.75 * number <= named <= 0.95 * number)]


def _of_case(_: None, case: Case, laws: int) -> list[Injected]:
    machine = made(case)
    fit = [as_log(machine.robot, machine.fit, "the log to fit")]
    heldout = [as_log(machine.robot, machine.heldout, "the log held out")]
    with threadpool_limits(1):
        search = searched(machine.robot, fit, runs_here)
        told = concluded(search, runs_here, heldout)
        if told.verdict != "nothing_detectable" or search.examination.setting.alignment.needed:
            return []
        shown = [limit for limit in told.limits if not limit.reason]
        rng = np.random.default_rng([*case.seed, 2])
        drawn = rng.choice(len(shown), min(laws, len(shown)), replace=False)
        return [_injected(machine.robot, case, search, shown[i], fit, heldout) for i in drawn]


def _injected(
    robot: Robot, case: Case, search: Search, limit: Limit, fit: list[Log], heldout: list[Log]
) -> Injected:
    candidate = _at_limit(search, limit)
    with_law = [[_with(search.robot, candidate, limit, log) for log in logs] for logs in (fit, heldout)]
    told = concluded(searched(robot, with_law[0], runs_here), runs_here, with_law[1])
    named = {(n.effect, n.joint) for finding in told.findings for n in finding.tie}
    at = limit.effect, limit.joint
    return Injected(case.id, *at, limit.share_percent, at in named, told.sentence)


def _at_limit(search: Search, limit: Limit) -> Candidate:
    """The nonlinear values that the limit is of."""
    family = limit.effect, joint_number(limit.joint)
    pairs = zip(search.examination.candidates, search.examination.gains, strict=True)
    own = ((c, gain) for c, gain in pairs if (c.effect, c.joint) == family)
    return min(own, key=lambda pair: float(pair[1].alone.min()))[0]


def _with(robot: Robot, candidate: Candidate, limit: Limit, log: Log) -> Log:
    """The log of the robot with a law, which is put in by its first parameter alone."""
    motion = denoised_every_sample(robot, log).motion
    name, size = next(iter(limit.smallest.items()))
    torques = dict(_torques(slopes(robot, candidate, motion)[name], size, log))
    return replace(log, frame=log.frame.assign(**torques))


def _torques(columns: dict[int, np.ndarray], size: float, log: Log) -> Iterator[tuple[str, np.ndarray]]:
    for joint, column in columns.items():
        name = f"joint{joint + 1}.tau"
        measured = log.frame[name].to_numpy()
        ends = (len(measured) - len(column)) // 2  # which the differences of the motion lose
        yield name, measured + size * np.pad(column, ends, mode="edge")
