"""Robots that hide an effect, their torques taken out of the logs: what does the diagnosis still name?"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd

from flexmodels.atomic import replacing
from flexmodels.coordinate import torque_of
from flexmodels.robot import Robot
from pyident.logs.log import Log, read_log
from pyident.refinement.loop_torque import UNSEEN
from pyident.rules.rules import RULES
from pyident.sweep.studies import StudyResult, row
from pyident.verbs.inputs import Given, given

from ..hidden_effect.blind import ROBOT, notes_of, solve_all
from ..hidden_effect.generator.cases import LOGS, Case
from ..hidden_effect.generator.logs_and_key import cases_of
from ..hidden_effect.scoring import NAMING, Scored, share, table, unseal

SEED = 2083  # never scored before, nor used for a rule
MOTOR = (
    "stribeck", "asymmetric_coulomb", "load_dependent_friction", "presliding", "nonlinear_viscous",
    "position_dependent_friction", "viscous_drift", "torque_ripple", "gravity_spring", "joint_spring",
    "joint_coupling",
)  # fmt: skip
DRIVE = ("torque_delay", "torque_saturation")  # between command and torque: what such a log may not show
NULLS = 2


def run(
    folder: Path, progress: Callable[[float], None], seed: int = SEED, cases: int | None = None
) -> StudyResult:
    """Make, diagnose and score: every law of the motor's side, both of the drive, two robots without any.

    cases   the first so many of them; none: all
    """
    drawn = cases_of([*MOTOR, *DRIVE, *["null"] * NULLS], seed, ROBOT)[:cases]
    solve_all(drawn, folder, RULES.replicas.count, progress, read=torqueless)
    return report(drawn, folder)


def torqueless(folder: Path, robot: Robot) -> Given:
    """The logs of a case as somebody brings them who has recorded no torque."""
    logs = [_bare(read_log(folder / f"{name}.parquet"), robot) for name in LOGS]
    return given(robot, logs[:2], heldout=logs[2:])


def report(drawn: list[Case], folder: Path) -> StudyResult:
    """Score table; cases.csv in `folder`."""
    scored = [unseal(folder, case.id) for case in drawn]
    listed = table(scored)
    with replacing(folder / "cases.csv") as file:
        listed.to_csv(file, index=False)
    said = [any(UNSEEN in note for note in notes_of(folder, c.id)) for c in scored]
    return StudyResult(rows(scored, said), [folder / "cases.csv"], _lines(listed))


def rows(cases: list[Scored], said: list[bool]) -> list[dict[str, str]]:
    """The table. said: per case whether its result tells where the torque came from and what that hides."""
    motor = [c for c in cases if c.truth and c.truth[0][0] in MOTOR]
    drive = [c for c in cases if c.truth and c.truth[0][0] in DRIVE]
    none = [c for c in cases if c.kind == "null"]
    return [
        share("motor's side: named, in the first tie", [_named(c) for c in motor], least=80),
        share("motor's side: strictly first", [c.first_tie[:1] == c.truth for c in motor]),
        share("motor's side: a further finding without the truth", [_beside(c) for c in motor]),
        share("drive (delay, saturation): named", [_named(c) for c in drive]),
        share("false alarm with nothing hidden", [c.verdict != "nothing_detectable" for c in none], most=5),
        share("says what it can no longer see", said, least=100),
        row("failed cases", str(sum(bool(c.failure) for c in cases)), "0", not any(c.failure for c in cases)),
    ]


def _named(case: Scored) -> bool:
    return case.verdict in NAMING and case.truth[0] in case.first_tie


def _beside(case: Scored) -> bool:
    return any(case.truth[0] not in tie for tie in case.ties[1:])


def _bare(log: Log, robot: Robot) -> Log:
    torques = [torque_of(k) for k, _ in robot.numbered]
    return replace(log, frame=log.frame.drop(columns=torques))


def _lines(listed: pd.DataFrame) -> list[str]:
    return [
        f"{line['truth'] or 'nothing hidden'} -> {line['failure'] or line['verdict']} {line['names']}"
        for line in listed.to_dict("records")
    ]
