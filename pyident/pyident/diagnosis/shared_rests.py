"""Where a law that explains the logs has friction whose sign is that of a sum of speeds.

A model without the law knows nothing of that sum, so that its equations hold the sum's reversals, too. There
the sign is not known, and what the law leaves then would read as something else that is missing. So these
equations are left out, and all of it is judged again.
"""

from flexmodels.effects.rubbing import rubbing
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.search.found import Found
from pyident.diagnosis.search.gate import region_of, share_in
from pyident.diagnosis.search.search import Search


def without_shared_rests(robot: Robot, search: Search) -> Robot:
    """The robot whose equations lack the rests of what explains most of a search's; itself, if that is none.

    Each equation has but one such law: the one that explains most of all that act on it.
    """
    examination, taken, found = search.examination, set(), []
    each = zip(examination.candidates, examination.gains, examination.columns, strict=True)
    for candidate, _, columns in sorted(each, key=lambda one: -one[1].energy):
        rows = {row for by_row in columns for row, X in by_row.items() if X.any()}
        if taken.isdisjoint(rows) and _shares(robot, candidate):
            best = search.best(candidate.effect, candidate.joint)
            if best is not None and _explains(search, best):
                found.append((candidate.joint, candidate.effect, best.candidate.values))
        taken |= rows
        if len(taken) == len(robot.q):
            break
    return robot.with_settings(rests=tuple(found)) if found else robot


def _explains(search: Search, law: Found) -> bool:
    """Whether it takes as much as a name needs: what only bends to a few samples near rest does not."""
    share = share_in(search, [law.candidate], region_of(search, law.candidate))
    return search.p_value(law) <= search.rules.level and share >= search.rules.needed(1)


def _shares(robot: Robot, candidate: Candidate) -> bool:
    """Whether its friction takes the sign of a sum of several joints' speeds."""
    sums = (s for each in rubbing(law_of(robot, candidate)).values() for s in each)
    return not candidate.describes and any(len(factors) > 1 for factors in sums)
