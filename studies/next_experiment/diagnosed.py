"""What a diagnosis says of a robot before and after it has run a designed motion; it is told of no rival."""

from collections.abc import Sequence

import pyident as pi
from flexmodels.coordinate import joint_name
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.excitation.rehearsals.rehearsal import Rehearsal
from pyident.excitation.separation.rivals import Suspect

ALONE, TIED, OTHER, NOTHING = "alone", "in a tie", "the other", "not named"
_SEEDS = (1, 2)  # of the noise: of a log to fit, and of one that is held out


def verdicts(
    model: Robot,
    real: Rehearsal,
    plans: Sequence[Experiment],
    noise: dict[str, float],
    truth: Suspect,
    other: Suspect,
) -> list[str]:
    """How the true law is named from the first plan's log, from those of the first two, and so on."""
    logs = [real.noisy(plan, noise, _SEEDS) for plan in plans]
    out = []
    for count in range(1, len(plans) + 1):
        fitted, unseen = ([of[i] for of in logs[:count]] for i in range(2))
        found = pi.diagnose(model, fitted, heldout=unseen).diagnosis
        ties = [{(n.effect, n.joint) for n in finding.tie} for finding in found.findings]
        out.append(_named(ties, truth, other))
    return out


def _named(ties: Sequence[set[tuple[str, str]]], truth: Suspect, other: Suspect) -> str:
    right, wrong = ((who.effect, joint_name(who.joint)) for who in (truth, other))
    if {right} in ties:
        return ALONE
    if any(right in tie for tie in ties):
        return TIED
    return OTHER if any(wrong in tie for tie in ties) else NOTHING
