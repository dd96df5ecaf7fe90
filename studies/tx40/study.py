"""TX40: six measured axes, with and without what ties the wrist's last two."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.coordinate import of_joint
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import weighted
from pyident.estimation.identify import Identified, identified, identify
from pyident.logs.datasets import fetch
from pyident.logs.foreign import import_log
from pyident.logs.log import Log, LogError
from pyident.logs.mapping import read_mapping
from pyident.regression.equations import Problem
from pyident.report.page import Section, write_page
from pyident.sweep.studies import StudyResult, row

# Weighted least squares of the data's authors: viscous [N m s/rad] and Coulomb [N m] friction, joints 1 to 6.
VISCOUS = (8.08729, 5.593924, 1.98261, 1.112374, 1.854047, 0.647663)
COULOMB = (7.014425, 8.134077, 6.282682, 2.490079, 3.041052)
COUPLING = (0.007724, 0.616288, 1.956284)  # inertia, viscous, Coulomb
ERROR, WRIST = 6.8, 12.0  # [%] relative torque error of all joints, of joint 5; axes at rest included


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Identify the measured run twice. Without the data the table says so."""
    robot = load_robot("tx40")
    try:
        log = import_log(fetch("tx40", download=False), read_mapping("tx40"), robot)
    except LogError as error:
        return StudyResult([], notes=[f"skipped: {error}"])
    coupled = identify(robot, [log])
    resting = _with_rests(robot, log)
    progress(0.5)
    free = identify(robot.without_effect("joint_coupling"), [log])
    progress(1.0)
    table = _table(coupled)
    errors = pd.DataFrame({"with coupling": coupled.relative_error, "without": free.relative_error})
    page = write_page(
        folder / "index.html",
        "TX40",
        "Friction and torque errors of a Staubli TX40, measured at 5 kHz, beside published values.",
        [
            Section("Friction", "Identified and published values.", table=table),
            Section("Relative torque error, %", "What the coupling of the wrist explains.", table=errors),
        ],
    )
    return StudyResult([*_friction_rows(table), *_error_rows(coupled, free, resting)], [page])


def published_friction() -> dict[str, float]:
    """Name -> the authors' value: friction of the joints, and what ties the wrist's last two."""
    published = {of_joint(k, "viscous"): v for k, v in enumerate(VISCOUS, start=1)}
    published |= {of_joint(k, "coulomb"): v for k, v in enumerate(COULOMB, start=1)}
    names = ("inertia", "viscous", "coulomb")
    return published | {f"joint5.joint_coupling.{n}": v for n, v in zip(names, COUPLING, strict=True)}


def _with_rests(robot: Robot, log: Log) -> Identified:
    """The same of all equations, those of axes at rest too, whose friction is not known."""
    part = condition(log, robot)
    every = replace(part, use=np.ones_like(part.use))
    found = weighted(Problem(robot, (every,))).with_long_memory()
    return identified(robot, found.reduced, found.solution)


def _table(found: Identified) -> pd.DataFrame:
    p = dict(zip(found.reduced.columns, found.solution.p, strict=True))
    published = published_friction()
    table = pd.DataFrame({"identified": {name: p[name] for name in published}, "published": published})
    return table.assign(**{"off %": 100 * (table["identified"] / table["published"] - 1)})


def _friction_rows(table: pd.DataFrame) -> list[dict[str, str]]:
    rows = []
    for name, goal in (("viscous", 3.0), ("coulomb", 5.0)):
        off = table.loc[[n for n in table.index if n.split(".")[1] == name], "off %"].abs()
        text = f"{off.max():.1f} % off the published at most ({off.idxmax()})"
        rows.append(row(f"{name} friction", text, f"{goal:g} %", bool(off.max() <= goal)))
    return rows


def _error_rows(coupled: Identified, free: Identified, resting: Identified) -> list[dict[str, str]]:
    def text(found: Identified) -> str:
        each = ", ".join(f"{v:.1f}" for name, v in found.relative_error.items() if name != "all")
        return f"{found.relative_error['all']:.2f} %; {each} %"

    total, wrist = resting.relative_error["all"], resting.relative_error["joint5"]
    return [
        row("relative torque error, all and joints 1 to 6", text(coupled)),
        row("the same without the wrist's coupling", text(free)),
        row("axes at rest included, all", f"{total:.2f} %", f"{ERROR} %", total <= ERROR),
        row("axes at rest included, joint 5", f"{wrist:.1f} %", f"{WRIST:g} %", wrist <= WRIST),
        row("axes at rest included, all and joints 1 to 6", text(resting)),
    ]
