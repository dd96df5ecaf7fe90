"""What is left where replicas have the law that explains most, too.

A play that rattles, or a torque that saturates, shakes a whole arm at frequencies that a log hardly holds,
and the equations of other hinges leave more for it than in replicas of a model that has no such law. So where
a law is named and anything is left beside it, replicas are made of the model with that law. What they leave
beside it is the least that counts as a floor, band by band, and laws and errors are asked again. A second
effect that is there exceeds these floors as well.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexmodels.inputs import SimulationError
from pyident.diagnosis.base.candidates import Candidate, with_law
from pyident.diagnosis.base.residual_over_floor import Examination, examine
from pyident.diagnosis.base.ringing_hinges import with_ringing_matched
from pyident.diagnosis.base.setting import Setting, set_up, unbiased, workers_of
from pyident.diagnosis.rounds.asked import Asked, selected
from pyident.diagnosis.search.found import candidates_of
from pyident.diagnosis.search.gate import region_of, share_in
from pyident.diagnosis.search.search import Search, search_of
from pyident.diagnosis.search.selection import Selection
from pyident.logs.log import LogError
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]


def beside_its_replicas(asked: Asked, open_pool: OpenPool, progress: Progress) -> Asked:
    """What a search has come to over floors no lower than those of a model with its first law.

    As it was where nothing is left and all else that is named takes all of it, where nothing is simulated,
    where the model with the law cannot be, or where the law itself does not exceed such floors.
    """
    search, held, selection = asked
    lead = selection.steps[0].best.candidate if selection.steps else None
    if lead is None or lead.describes or not search.examination.setting.follows:
        return asked
    if not search.resting_on(selection.candidates).stands_out and _whole(search, selection):
        return asked
    try:
        having = _replicated(search.examination.setting, lead, open_pool, progress)
    except (SimulationError, LogError):
        return asked
    over = search_of(_over_floors_of(search.examination, having)).resting_on(())
    again = selected(over, held)
    still = lead.family in [c.family for c in again.candidates]
    return (over, held, again) if still else asked


def _whole(search: Search, selection: Selection) -> bool:
    """Whether each but the first that is named takes all that is missing where it acts."""
    for step in selection.steps[1:]:
        others = candidates_of(s for s in selection.steps if s is not step)
        view = search.resting_on(others)
        if share_in(view, step.candidates, region_of(view, step.best.candidate)) < search.rules.whole:
            return False
    return True


def _replicated(setting: Setting, law: Candidate, open_pool: OpenPool, progress: Progress) -> Examination:
    """The logs, and replicas of a model with a law, under that model. Raises LogError, SimulationError."""
    robot = with_law(setting.robot, law)
    having = set_up(robot, setting.logs, setting.rules, setting.estimator, setting.alignment)
    with workers_of(having, open_pool) as workers:
        free = with_ringing_matched(unbiased(having, workers), workers)
        return examine(free, workers, progress, lambda *_: [])


def _over_floors_of(ex: Examination, having: Examination) -> Examination:
    """An examination whose replicas leave no less, on any equation and in any band, than others do.

    having   the same logs' under another model
    """
    count = np.maximum(sum(inside.sum(axis=0) for inside in ex.bands), 1)
    pairs = zip(having.levels, ex.levels, ex.bands, strict=True)
    unit = sum(np.square(theirs / own) @ inside for theirs, own, inside in pairs) / count
    theirs, own = having.replica_energy.mean(axis=0) * unit, ex.replica_energy.mean(axis=0)
    times = np.maximum(theirs / np.maximum(own, 1e-300), 1.0)
    sizes = [np.sqrt(np.where(inside.any(axis=1), times @ inside.T, 1.0)) for inside in ex.bands]
    residuals = [[r * size for r, size in zip(made, sizes, strict=True)] for made in ex.replica_residuals]
    return replace(ex, replica_energy=ex.replica_energy * times, replica_residuals=residuals)
