"""What is left where replicas have the law that explains most, too.

A play that rattles, or a torque that saturates, shakes a whole arm at frequencies that a log hardly holds,
and the equations of other hinges leave more for it than in replicas of a model that has no such law. So where
a law is named and anything is left beside it, replicas are made of the model with that law. What they leave
beside it is the least that counts as a floor, band by band, and laws and errors are asked again. A second
effect that is there exceeds these floors as well. Where the logs leave nothing beyond them beside one law as
it is, that law is all that is missing: whatever else was named, or nothing, is what it shakes.
"""

from collections.abc import Callable

import numpy as np

from flexmodels.inputs import SimulationError
from pyident.diagnosis.base.candidates import Family
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.diagnosis.base.standing_out import over_floor, standing_out
from pyident.diagnosis.imitators.fault import fault_of
from pyident.diagnosis.rounds.asked import Asked, selected, take_all
from pyident.diagnosis.rounds.replicas_with_laws import beside_laws, over_floors_of, replicated
from pyident.diagnosis.search.found import Step
from pyident.diagnosis.search.gate import admission, counts
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search, search_of
from pyident.diagnosis.search.selection import Selection
from pyident.diagnosis.searched import part_of
from pyident.logs.log import LogError
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]
_LAWS = 3  # whose models are simulated: each costs as much as a search


def beside_its_replicas(asked: Asked, open_pool: OpenPool, progress: Progress) -> Asked:
    """What a search has come to over floors no lower than those of a model with a law.

    That law alone where it leaves nothing there; else what is asked anew over the floors of the first that is
    named. As it was where nothing is left and all else that is named takes all of it, where nothing is
    simulated, where no model with a law can be, or where the law itself does not exceed such floors.
    """
    search, held, selection = asked
    laws = _laws(search, selection) if search.examination.setting.follows else []
    if not laws:
        return asked
    if not search.resting_on(selection.candidates).stands_out and take_all(
        search, selection.steps, selection.steps[1:]
    ):
        return asked
    first: Asked | None = None
    out = search.resting_on(()).standing_out
    families = {c.family for c in selection.candidates}
    for number, step in enumerate(laws):
        law = step.best.candidate
        told = part_of(progress, number / len(laws), 1 / len(laws))
        try:
            having = replicated(search.examination.setting, [law], open_pool, told, families)
        except (SimulationError, LogError):
            continue
        over = over_floors_of(search.examination, having)
        if _leaves_nothing(having, out, families - {law.family}):
            alone = search_of(beside_laws(over, step.candidates, having)).resting_on(())
            if _passes(alone, step, held):
                return alone, held, Selection((step,), selection.first, selection.imitators)
        elif step in selection.steps and first is None:
            again = search_of(over).resting_on(())
            first = again, held, selected(again, held)
    lead = selection.candidates[0].family if selection.steps else None
    still = first is not None and lead in [c.family for c in first[2].candidates]
    return first if first is not None and still else asked


def _laws(search: Search, selection: Selection) -> list[Step]:
    """Laws that are named, then those that come nearest at places that nothing explains, a few in all."""
    named = [step for step in selection.steps if not step.best.candidate.describes]
    families = [step.best.candidate.family for step in named]
    least = 100 * search.rules.part
    near = [r.candidate.family for r in selection.refusals if r.certain and r.share_percent >= least]
    ranked = selection.first.ranked
    of_family = {f.candidate.family: f for f in ranked}
    found = [of_family[family] for family in dict.fromkeys(near) if family in of_family]
    laws = [f for f in found if not f.candidate.describes and f.candidate.log is None]
    others = [search.led_by(f, [f, *(g for g in ranked if g is not f)]) for f in laws]
    return [*named, *(step for step in others if step.best.candidate.family not in families)][:_LAWS]


def _leaves_nothing(having: Examination, where: np.ndarray, named: set[Family]) -> bool:
    """Whether logs leave beside a law what replicas of a model with it leave: no more, nor far less on the
    equations (n,) where they left much without it, which floors that are too high would hide.

    named   what else was, none of which may count there; the law does not stand for what cannot be asked
    """
    if standing_out(having, having.base).any() or not named <= {c.family for c in having.candidates}:
        return False
    if named:
        view = search_of(having)
        if any(counts(view, found) for found in view.step().ranked):
            return False
    least = having.setting.rules.search.below_floor**2
    return bool((over_floor(having, having.base)[where] >= least).all())


def _passes(over: Search, step: Step, held: HeldOut) -> bool:
    """Whether a law by itself may be named over floors of a model that has it."""
    entry = admission(over, step.best, step.candidates, held)
    enough = entry.share >= over.rules.needed(1)
    whole = over.resting_on(step.candidates)
    return enough and not entry.reason and not fault_of(whole, step.best.candidate)
