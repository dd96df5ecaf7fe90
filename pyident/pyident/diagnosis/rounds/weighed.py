"""Equations weighed anew beside what is named."""

from collections.abc import Callable, Sequence

from pyident.diagnosis.rounds.asked import Asked, selected
from pyident.diagnosis.search.held_out import held_out
from pyident.diagnosis.searched import weighed_anew
from pyident.logs.log import Log
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]
_RAISED = 2.0  # times that a floor is raised, so that its equation counts for much less


def weighed(asked: Asked, heldout: Sequence[Log], open_pool: OpenPool, progress: Progress) -> Asked:
    """What laws and errors come to where floors are raised by what the model lacks beside those named, if
    that leaves far less: an equation that lacks much counts for little, and then others bend its laws.
    """
    search, _, selection = asked
    beside = search.resting_on(selection.candidates)
    if not selection.steps or search.examination.raised.max() < _RAISED or not beside.stands_out:
        return asked
    again = weighed_anew(search, selection.candidates, open_pool, progress)
    unseen = held_out(again, heldout)
    anew = selected(again, unseen)
    before, after = (again.resting_on(s.candidates).lacking.sum() for s in (selection, anew))
    return (again, unseen, anew) if after <= (1 - search.rules.explained[0]) * before else asked
