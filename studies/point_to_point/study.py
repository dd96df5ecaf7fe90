"""Robots that hide an effect and move as they work, from point to point: what does the diagnosis say?"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from flexmodels.atomic import replacing
from pyident.rules.rules import RULES
from pyident.sweep.studies import StudyResult

from ..hidden_effect.blind import ROBOT, solve_all
from ..hidden_effect.generator.cases import Case, paced
from ..hidden_effect.generator.logs_and_key import cases_of
from ..hidden_effect.scoring import score, table, unseal

SEED = 2151
LAWS = (
    "stribeck", "load_dependent_friction", "presliding", "nonlinear_viscous", "torque_ripple",
    "gravity_spring", "joint_coupling", "backlash", "stiffness_coupling", "kinematic_error",
)  # fmt: skip
PAIRS = ("stribeck+backlash", "gravity_spring+nonlinear_viscous")
NULLS = 6
PACES = (0.6, 1.4)  # rad/s


def run(
    folder: Path, progress: Callable[[float], None], seed: int = SEED, cases: int | None = None
) -> StudyResult:
    """Make, diagnose and score: robots with nothing hidden, ten laws, two pairs.

    cases   the first so many of them; none: all
    """
    listed = [working(case) for case in cases_of([*["null"] * NULLS, *LAWS, *PAIRS], seed, ROBOT)][:cases]
    solve_all(listed, folder, RULES.replicas.count, progress)
    scored = [unseal(folder, case.id) for case in listed]
    with replacing(folder / "cases.csv") as file:
        table(scored).to_csv(file, index=False)
    rows = [row for row in score(scored) if row["value"] != "no cases"]
    return StudyResult(rows, [folder / "cases.csv"])


def working(case: Case) -> Case:
    """The case with every log from point to point, each at a pace of its own; no torque is fed forward."""
    paces = np.random.default_rng([case.seed, 1]).uniform(*PACES, len(case.plans))
    return replace(case, plans=tuple(map(paced, case.plans, paces.tolist())))
