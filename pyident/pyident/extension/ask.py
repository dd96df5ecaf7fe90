"""What the gate of a diagnosis says of one effect that somebody wants to add."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from flexmodels.robot import Robot, RobotError
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.order_peaks import order_peaks
from pyident.diagnosis.base.residual_over_floor import examine
from pyident.diagnosis.base.setting import Setting, workers_of
from pyident.diagnosis.search.found import Found
from pyident.diagnosis.search.gate import Admission, admission
from pyident.diagnosis.search.held_out import held_out
from pyident.diagnosis.search.search import Search, search_of
from pyident.logs.log import Log
from pyident.regression.candidate_columns import coverage, nonlinear_grid
from pyident.regression.descriptions import describes
from pyident.regression.spectrum import Equations
from pyident.rules.periodic import PeriodicRules
from pyident.simulation.simulator import OpenPool

_HARDLY = 0.2  # of the samples that a law needs to be seen: with fewer, any coefficient would do


@dataclass(frozen=True)
class Asked:
    """A candidate at its best values beside the model, and what the gate says."""

    search: Search
    found: Found
    admission: Admission

    @property
    def candidate(self) -> Candidate:
        return self.found.candidate

    def json(self) -> dict[str, Any]:
        """Shares in percent of what exceeds the floor where the effect acts."""
        unseen = self.admission.unseen
        return {
            "reason": self.admission.reason,
            "p_value": self.admission.p_value,
            "share_percent": 100 * self.admission.share,
            "heldout_percent": None if unseen is None else 100 * unseen.share,
            "heldout_std_percent": None if unseen is None else 100 * unseen.std,
        }


def ask(
    setting: Setting,
    joint: int,
    effect: str,
    heldout: Sequence[Log],
    open_pool: OpenPool,
    progress: Callable[[float], None],
) -> Asked:
    """setting: of the model without the effect, as a diagnosis looks at its logs.

    Raises LogError, RobotError.
    """
    with workers_of(setting, open_pool) as workers:
        search = search_of(examine(setting, workers, progress, partial(_listed, joint, effect)))
    found = search.best(effect, joint)
    if found is None:
        raise RobotError(f"effect {effect} cannot act at joint {joint} of robot {setting.robot.name}")
    entry = admission(search, found, [found.candidate], held_out(search, heldout))
    return Asked(search, found, entry)


def _listed(
    joint: int, effect: str, robot: Robot, data: Sequence[Equations], p: np.ndarray, rules: PeriodicRules
) -> list[Candidate]:
    """The effect over its nonlinear parameters as a diagnosis tries them, as far as a log shows it there."""
    if describes(effect):
        return [Candidate(effect, joint)]
    motions = [log.part.motion for log in data]
    grid, law = nonlinear_grid(robot, joint, effect, motions), robot.joints[joint - 1].law(effect)
    if law.order is not None:
        grid = order_peaks(robot, data, p, rules, [joint])[joint].beside(grid, law)

    def shown(values: dict[str, float]) -> bool:
        covered = [coverage(robot, joint, effect, motion, values) for motion in motions]
        return any(share is None or share >= _HARDLY for share in covered)

    seen = [values for values in grid if shown(values)]
    return [Candidate(effect, joint, tuple(values.items())) for values in seen or grid]
