"""Laws with which a model follows logs that no simulation of it follows without.

What a robot lacks may bend its fit so far that it shakes, or falls. Then there is the sensors' noise alone to
tell what stands out of it, and nothing may be named: it shows nothing of what the method leaves by itself.
But a model with what is missing follows. So the laws that explain most beyond the noise are joined to the
model, one after the other, until a simulation of its fit follows the logs; laws that explain what is left
beyond its replicas are joined as well. The floors of those replicas, whose truth has the laws, are then
floors of the search without them. As no replica of a model without laws tells what else does nearly as well,
something is named only if each takes all that is missing where it acts.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from flexmodels.inputs import SimulationError
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.floor_shares import worth_little
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.diagnosis.base.standing_out import standing_out
from pyident.diagnosis.rounds.asked import Asked, selected, take_all
from pyident.diagnosis.rounds.replicas_with_laws import beside_laws, over_floors_of, replicated
from pyident.diagnosis.search.found import others_than
from pyident.diagnosis.search.gate import region_of
from pyident.diagnosis.search.held_out import held_out
from pyident.diagnosis.search.search import Search, search_of
from pyident.diagnosis.search.selection import Selection
from pyident.diagnosis.searched import part_of
from pyident.logs.log import Log, LogError
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]
_FIRST, _TOGETHER = 2, 2  # laws of a ranking with which is begun, and joined at most: each model costs a fit


def with_laws_that_follow(
    search: Search, heldout: Sequence[Log], open_pool: OpenPool, progress: Progress
) -> Asked | None:
    """What the laws come to over floors of a model that follows the logs with some of them; None: none does.

    search   over the sensors' noise alone, as no simulation of the fit follows the logs
    """
    for number, proposed in enumerate(_proposed(search)):
        told = part_of(progress, number / (_FIRST * _TOGETHER), 1 / (_FIRST * _TOGETHER))
        having = _replicated(search, proposed, open_pool, part_of(told, 0.0, 0.6))
        if having is None:
            continue
        laws, having = _with_further(proposed, having, search, heldout, open_pool, part_of(told, 0.6, 0.3))
        over = beside_laws(over_floors_of(search.examination, having), laws, having)
        again = search_of(_told(over, laws)).resting_on(())
        held = held_out(again, heldout)
        selection = _where_it_matters(again, selected(again, held), laws, having)
        if selection.steps and take_all(again, selection.steps, selection.steps):
            return again, held, selection
    return None


def _where_it_matters(
    search: Search, selection: Selection, laws: Sequence[Candidate], having: Examination
) -> Selection:
    """What is named where logs leave far more than replicas: laws, and others only beyond a model with them.

    Along a motion with the sensors' noise once more no replica shows how far noise bends a hinge's stiffness.
    """
    out, families = standing_out(having, having.base), {law.family for law in laws}
    kept = []
    for step in selection.steps:
        view = search.resting_on(others_than(step, selection.steps))
        region = region_of(view, step.best.candidate)
        given = not families.isdisjoint(f.candidate.family for f in step.tie)
        if view.stands_out_in(region) and (given or out[list(region.rows)].any()):
            kept.append(step)
    return replace(selection, steps=tuple(kept))


def _proposed(search: Search) -> Iterator[list[Candidate]]:
    """Each of the laws that explain most, and then what explains most of the rest beside it."""
    for first in _ranked(search)[:_FIRST]:
        laws = [first]
        yield list(laws)
        while len(laws) < _TOGETHER:
            beside = search.resting_on(laws)
            taken = {(c.effect, c.joint) for c in laws}
            more = [c for c in _ranked(beside) if (c.effect, c.joint) not in taken]
            if not more or not beside.stands_out:
                break
            laws.append(more[0])
            yield list(laws)


def _ranked(search: Search) -> list[Candidate]:
    """Laws of all logs that explain more of what is left than chance does, the most first."""
    ranked = [f for f in search.step().ranked if search.p_value(f) <= search.rules.level]
    return [f.candidate for f in ranked if not f.candidate.describes and f.candidate.log is None]


def _with_further(
    laws: list[Candidate],
    having: Examination,
    search: Search,
    heldout: Sequence[Log],
    open_pool: OpenPool,
    progress: Progress,
) -> tuple[list[Candidate], Examination]:
    """Those laws and the ones that are named beside them, and replicas of a model with all of them."""
    view = search_of(having).resting_on(())
    if not view.stands_out:
        return laws, having
    named = [step.best.candidate for step in selected(view, held_out(view, heldout)).steps]
    further = [c for c in named if not c.describes and c.log is None]
    more = _replicated(search, [*laws, *further], open_pool, progress) if further else None
    return (laws, having) if more is None else ([*laws, *further], more)


def _replicated(
    search: Search, laws: Sequence[Candidate], open_pool: OpenPool, progress: Progress
) -> Examination | None:
    """Replicas of a model with laws, if they are worth something."""
    try:
        having = replicated(search.examination.setting, laws, open_pool, progress)
    except (SimulationError, LogError):
        return None
    return None if worth_little(having) else having


def _told(ex: Examination, laws: Sequence[Candidate]) -> Examination:
    """The examination that says by which laws a model follows."""
    names = ", ".join(f"{c.effect} at joint{c.joint}" for c in laws)
    said = (
        f"no simulation of the fitted model follows these logs; one with {names} does, and the floors are "
        "those of its replicas"
    )
    return replace(ex, setting=replace(ex.setting, unfollowed=said))
