"""What the gate of a diagnosis says of one effect that somebody wants to add."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from flexmodels.robot import RobotError
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.residual_over_floor import examine
from pyident.diagnosis.base.setting import Setting, workers_of
from pyident.diagnosis.search.gate import Admission, admission
from pyident.diagnosis.search.held_out import held_out
from pyident.diagnosis.search.search import Found, Search, search_of
from pyident.logs.log import Log
from pyident.regression.candidate_columns import coverage, nonlinear_grid
from pyident.regression.descriptions import describes
from pyident.simulation.simulator import OpenPool


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
        search = search_of(examine(setting, workers, progress, _listed(setting, joint, effect)))
    found = search.best(effect, joint)
    if found is None:
        raise RobotError(f"effect {effect} cannot act at joint {joint} of robot {setting.robot.name}")
    entry = admission(search, found, [found.candidate], held_out(search, heldout))
    return Asked(search, found, entry)


def _listed(setting: Setting, joint: int, effect: str) -> list[Candidate]:
    """The effect over the grid of its nonlinear parameters, as far as any log shows it at them."""
    if describes(effect):
        return [Candidate(effect, joint)]
    robot = setting.robot
    motions = [condition(log, robot).motion for log in setting.logs]
    grid = nonlinear_grid(robot, joint, effect, motions)

    def shown(values: dict[str, float]) -> bool:
        covered = [coverage(robot, joint, effect, motion, values) for motion in motions]
        return any(share is None or share >= 1 for share in covered)

    seen = [values for values in grid if shown(values)]
    # where the logs hardly are, any coefficient would do
    return [Candidate(effect, joint, tuple(values.items())) for values in seen or grid]
