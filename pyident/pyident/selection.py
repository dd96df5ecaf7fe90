"""How many effects are named: the fewest that explain most of the excess, then those that stand alone.

A set is looked for first, one effect, then two ... that takes away most of the excess. Once there is one, a
further effect must take away most of what still exceeds the floor on its own equations: what an inexact law
leaves behind is shared among many candidates, a true effect is taken by one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from pyident.candidates import Candidate
from pyident.search import ALPHA, Found, Search, Step

MATERIAL = 0.005  # of the floor's energy: a smaller gain is not worth a name
EXPLAINED = (0.6, 0.7, 0.8)  # of the excess, by a set of one, two or three effects
PART = 0.1  # of the excess: what each must contribute
OWN = 0.5  # of what still exceeds the floor on its own equations: what a further effect must take away
MOST = 4  # effects at once


@dataclass(frozen=True)
class Selection:
    """What was selected.

    steps      one per effect, each ranked with all others in the base
    explained  share of the excess after the first of them, the first two ...
    first      the ranking with none selected
    """

    steps: tuple[Step, ...]
    explained: tuple[float, ...]
    first: Step

    @property
    def candidates(self) -> list[Candidate]:
        return [step.best.candidate for step in self.steps]


def select(search: Search) -> Selection:
    """Leaves the search resting on what it selects."""
    search.rest_on(())
    first = search.step()
    chosen = _explaining(search, first)
    if chosen:
        chosen = _judged_together(search, _standing(search, chosen))
    candidates = [step.best.candidate for step in chosen]
    explained = []
    for n in range(len(candidates)):
        search.rest_on(candidates[: n + 1])
        explained.append(search.explained)
    search.rest_on(candidates)
    return Selection(tuple(chosen), tuple(explained), first)


def _explaining(search: Search, step: Step) -> list[Step]:
    """The smallest set that explains enough, empty when there is none."""
    steps: list[Step] = []
    for needed in EXPLAINED:
        if not (_counts(search, step.best) and step.best.excess >= PART * search.excess):
            return []
        steps.append(step)
        search.rest_on([s.best.candidate for s in steps])
        if search.explained >= needed:
            return steps
        step = search.step()
    return []


def _standing(search: Search, steps: list[Step]) -> list[Step]:
    """With the further effects that stand by themselves."""
    while len(steps) < MOST:
        search.rest_on([s.best.candidate for s in steps])
        step = search.step()
        named = {f.candidate.family for s in steps for f in s.tie}
        others = (f for f in step.ranked if f.candidate.family not in named)
        further = next((f for f in others if _counts(search, f) and _owns(search, f)), None)
        if further is None:
            return steps
        steps = [*steps, step.led_by(further)]
    return steps


def _judged_together(search: Search, steps: Sequence[Step]) -> list[Step]:
    """Each effect ranked again with the others in the base; those that others have made needless are gone."""
    kept = [step.best for step in steps]
    out: list[Step] = []
    for found in list(kept):
        search.rest_on([f.candidate for f in kept if f is not found])
        step = search.step()
        again = next((f for f in step.ranked if f.candidate.family == found.candidate.family), None)
        if again is None or not _counts(search, again):
            kept.remove(found)
            continue
        rivals = [f for f in step.ranked if f.candidate.joint == found.candidate.joint and _counts(search, f)]
        others = {f.candidate.family for f in kept if f is not found}
        best = next(f for f in rivals if f.candidate.family not in others)
        kept[kept.index(found)] = best
        out.append(step.led_by(best))
    return out


def _counts(search: Search, found: Found) -> bool:
    return search.p_value(found) <= ALPHA and found.excess >= MATERIAL * search.floor_energy


def _owns(search: Search, found: Found) -> bool:
    """Whether it takes away most of what still exceeds the floor on its equations, and a part of what did."""
    rows = search.rows(found.candidate)
    return found.excess >= max(OWN * search.remaining_on(rows), PART * search.excess_on(rows))
