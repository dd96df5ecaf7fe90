"""Which effects are named, equation by equation.

The effect that explains most leads; with the fewest others that it needs it must explain most of what exceeds
the floor on the equations where it acts, and hold on logs that were not used (see `gate`). Its joint's next
effect must take away most of what is left there: what an inexact law leaves behind is shared among many
candidates, a true effect is taken by one. Where no effect passes, the equation stays unexplained and the
others go on. At last a law whose coefficients change over the logs is dropped, one whose gain rests on a few
samples away from where it acts, and one that leaves what depends on a signal that it does not know: they
stand in for something else (see `constancy`, `breadth`, `imitation`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.base.standing_out import bands_in_doubt
from pyident.diagnosis.imitators.fault import fault_of
from pyident.diagnosis.search.found import Found, Step, candidates_of
from pyident.diagnosis.search.further_orders import as_orders, with_orders
from pyident.diagnosis.search.gate import (
    Refusal,
    admission,
    counts,
    nothing_left,
    owns,
    region_of,
    sets_for,
    share_in,
)
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.remainder import may_be_remainder
from pyident.diagnosis.search.search import Search


@dataclass(frozen=True)
class Selection:
    """What was selected.

    steps      one per effect, each ranked with all others in the base
    first      the ranking with none selected
    imitators  what was dropped: effect and joint -> why
    refusals   the best candidate of every place that nothing explains
    notes      sentences on what may be wrong besides
    """

    steps: tuple[Step, ...]
    first: Step
    imitators: dict[str, str]
    refusals: tuple[Refusal, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def candidates(self) -> list[Candidate]:
        return candidates_of(self.steps)


def select(search: Search, held: HeldOut, given: Sequence[Step] = ()) -> Selection:
    """What a search comes to, whatever it rests on. given: what is named already, and stays."""
    search = search.resting_on(())
    first = search.step()
    chosen = list(given)
    refusals: dict[Region, Refusal] = {}
    imitators: dict[str, str] = {}
    view = search.resting_on(candidates_of(given))
    step = view.step()
    while len(chosen) < search.rules.most:
        lead = next((f for f in step.ranked if _may_lead(view, f, chosen, refusals)), None)
        if lead is None:
            break
        group, refusal, faults = _of_either_form(view, step, lead, chosen, held)
        imitators |= faults
        if refusal is not None:
            refusals[_worst(view, lead)] = refusal  # of the lead's own: it may have been exchanged
            continue
        chosen = with_orders(search, as_orders(chosen, group))
        view = search.resting_on(candidates_of(chosen))
        step = view.step()
    chosen = _judged_together(search, chosen, held, len(given))
    return Selection(tuple(chosen), first, imitators, tuple(refusals.values()))


def _may_lead(view: Search, found: Found, chosen: Sequence[Step], refusals: dict[Region, Refusal]) -> bool:
    """Not where something was refused already, nor what is named already; beside that, in other bands of the
    same rows, what by itself takes enough for a name.
    """
    named = {s.best.candidate.family for s in chosen}
    if found.candidate.family in named or not counts(view, found):
        return False
    region = region_of(view, found.candidate)
    if any(region.meets(refused) for refused in refusals):
        return False
    tried = any(not set(region.rows).isdisjoint(refused.rows) for refused in refusals)
    return not tried or share_in(view, [found.candidate], region) >= view.rules.needed(1)


def _worst(view: Search, lead: Found) -> Region:
    """The row and the band in which a lead leaves most to explain."""
    region = region_of(view, lead.candidate)
    cells = [Region((row,), (band,)) for row in region.rows for band in region.bands]
    return max(cells, key=view.remaining_in)


def _of_either_form(
    view: Search, step: Step, lead: Found, chosen: Sequence[Step], held: HeldOut
) -> tuple[list[Step], Refusal | None, dict[str, str]]:
    """As `_group`; where a wave with a size of its own at every speed fails, the one without is asked, too:
    its many parameters take up what another law leaves, and then hold on no other log.
    """
    group, refusal, faults = _group(view, step, lead, chosen, held)
    plain = next((f for f in step.ranked if f.other_form_of(lead) and not f.candidate.speeds), None)
    if group or plain is None or not counts(view, plain):
        return group, refusal, faults
    group, _, further = _group(view, step, plain, chosen, held)
    return group, None if group else refusal, faults | further


def _group(
    view: Search, step: Step, lead: Found, chosen: Sequence[Step], held: HeldOut
) -> tuple[list[Step], Refusal | None, dict[str, str]]:
    """The set that explains the lead's equations, else why there is none; and what only imitates, with why.

    Equations that have an effect already get one that takes the rest, or several that leave nothing. A larger
    set takes the place of a smaller one only where that leaves what stands out and it takes most of this.
    """
    region = region_of(view, lead.candidate)
    there = [s for s in chosen if not set(region.rows).isdisjoint(view.rows(s.best.candidate))]
    if any(may_be_remainder(view, lead.candidate, s, region) for s in there):
        found, why = _further(view, step, lead, chosen, held)
        return _checked(view, found, why, lead, chosen)
    best: list[Step] = []
    first: Refusal | None = None
    imitators: dict[str, str] = {}
    for found, why in sets_for(view, step, lead, held):
        if best and not _betters(view, found, best, region):
            continue
        group, why, faults = _checked(view, found, why, lead, chosen)
        imitators |= faults
        first = _firmer(first, why)
        best = group or best
        if not notable(view, region):
            break
        if best and not view.with_further(candidates_of(best)).stands_out_in(region):
            break
    return best, None if best else first, imitators


def notable(view: Search, region: Region) -> bool:
    """Whether so much is left in a region that more than one effect may be missing there."""
    doubted = bands_in_doubt(view.examination, view.base)[np.ix_(region.rows, region.bands)]
    return view.stands_out_in(region) or bool(doubted.any())


def _firmer(first: Refusal | None, later: Refusal | None) -> Refusal | None:
    """The first refusal; what a larger set shows on held-out logs counts for it, too."""
    if first is None or later is None:
        return first or later
    return replace(first, certain=first.certain or later.certain)


def _checked(
    view: Search, found: list[Step], why: Refusal | None, lead: Found, chosen: Sequence[Step]
) -> tuple[list[Step], Refusal | None, dict[str, str]]:
    """What passed the gate, with all its orders and without imitators."""
    if why is not None:
        return [], why, {}
    group, faults = _faultless(view, with_orders(view, [*chosen, *found])[len(chosen) :])
    return group, None if group else _imitator(view, lead, faults), faults


def _betters(view: Search, larger: Sequence[Step], smaller: Sequence[Step], region: Region) -> bool:
    """Whether a set takes most of what a smaller one leaves, and each of it a part of the whole."""
    least, left = view.rules.part * view.excess_in(region), view.with_further(candidates_of(smaller))
    each = [
        view.with_further(candidates_of([s for s in larger if s is not own])).remaining_in(region)
        for own in larger
    ]
    rest = view.with_further(candidates_of(larger)).remaining_in(region)
    mostly = rest <= (1 - view.rules.own) * left.remaining_in(region)
    return mostly and all(without - rest >= least for without in each)


def _further(
    view: Search, step: Step, lead: Found, chosen: Sequence[Step], held: HeldOut
) -> tuple[list[Step], Refusal | None]:
    """Effects beside those that its equations have already."""
    entry = admission(view, lead, [lead.candidate], held)
    if not owns(view, lead, entry.region):
        several = _several(view, step, lead, chosen, held)
        too_little = "beside the effects found there it takes too little of the rest"
        return several, None if several else replace(entry, reason=too_little).refusal
    if entry.reason:
        return [], entry.refusal
    found = view.led_by(lead, step.ranked)
    again = _left_by(view, found, chosen)
    if again:
        return [], replace(entry, reason=f"it is what {again} leaves of another form").refusal
    return [found], None


def _several(view: Search, step: Step, lead: Found, chosen: Sequence[Step], held: HeldOut) -> list[Step]:
    """Several further effects that together leave nothing of a rest too large to be an inexact law's."""
    region = region_of(view, lead.candidate)
    if view.remaining_in(region) < view.rules.part * view.excess_in(region):
        return []
    for found, why in sets_for(view, step, lead, held):
        if len(found) < 2 or why is not None or any(_left_by(view, s, chosen) for s in found):
            continue
        if share_in(view, candidates_of(found), region) >= view.rules.whole:
            return found
    return []


def _left_by(view: Search, step: Step, others: Sequence[Step]) -> str:
    """The law that was named already, in words, and whose inexact form a step mends; empty: none.

    The same law with other values explains as much as the step does, or what that law could not be told from
    takes most of it. The view rests on the others.
    """
    lead = step.best
    same = {f.candidate.family for f in step.tie if law_of(view.robot, f.candidate).order is None}
    for other in others:
        law = other.best.candidate
        rivals = [f.candidate for f in other.tie[1:] if f.candidate.joint == lead.candidate.joint]
        kept = view.with_further(rivals).gain_of(lead.candidate).energy if rivals else np.inf
        if law.family in same or kept < view.rules.apart * lead.gain.energy:
            return f"{law.effect} at joint{law.joint}"
    return ""


def _faultless(view: Search, group: list[Step]) -> tuple[list[Step], dict[str, str]]:
    """The group without imitators, where the rest explains enough; and the faults of those."""
    whole = view.with_further(candidates_of(group))
    faults = {id(s): fault_of(whole, s.best.candidate) for s in group}
    kept = [s for s in group if not faults[id(s)]]
    named = {f"{s.best.candidate.effect} at joint{s.best.candidate.joint}": faults[id(s)] for s in group}
    if 0 < len(kept) < len(group):
        region = region_of(view, kept[0].best.candidate)
        if share_in(view, candidates_of(kept), region) < view.rules.needed(len(kept)):
            kept = []
    return kept, {name: why for name, why in named.items() if why}


def _imitator(view: Search, lead: Found, faults: dict[str, str]) -> Refusal:
    region = region_of(view, lead.candidate)
    share = 100 * share_in(view, [lead.candidate], region)
    return Refusal(lead.candidate, region, share, None, next(iter(faults.values()), "it only imitates"))


def _judged_together(search: Search, steps: Sequence[Step], held: HeldOut, given: int) -> list[Step]:
    """Effects ranked again with the others in the base, but those given; needless ones are gone."""
    kept = list(steps)
    for old in steps[given:] if len(steps) > 1 else ():
        new = None
        while new is None and old in kept:
            new = _beside(search, old, [s for s in kept if s is not old], held)
            if new is None:
                kept.remove(_least_missed(search, kept[given:], old))
        if new is not None:
            kept[kept.index(old)] = new
    return kept


def _beside(search: Search, old: Step, others: Sequence[Step], held: HeldOut) -> Step | None:
    """An effect ranked again beside others; None where they have made it needless, or nothing is left."""
    view = search.resting_on([*candidates_of(others), *old.orders])
    step, family = view.step(), old.best.candidate.family
    again = next((f for f in step.ranked if f.candidate.family == family), None)
    if again is None or not counts(view, again) or nothing_left(view, region_of(view, again.candidate)):
        return None
    new = replace(_best_there(view, step, again, others, held), orders=())
    if _left_by(view, new, others):
        return None
    return replace(new, orders=old.orders if new.best.candidate.family == family else ())


def _least_missed(search: Search, kept: Sequence[Step], old: Step) -> Step:
    """Of an effect that does not stand beside the others, and those on its equations: which leaves least.

    What only mends the form of a law may leave that law with values which no such law has.
    """
    rows = search.rows(old.best.candidate)
    there = [s for s in kept if s is old or not set(rows).isdisjoint(search.rows(s.best.candidate))]
    without = (search.resting_on(candidates_of([s for s in kept if s is not gone])) for gone in there)
    left = [view.remaining_on(rows) for view in without]
    return there[int(np.argmin(left))]


def _best_there(view: Search, step: Step, again: Found, others: Sequence[Step], held: HeldOut) -> Step:
    """What takes most of an effect's equations beside the others: the effect itself or a rival that may."""
    named = {s.best.candidate.family for s in others}
    joint = again.candidate.joint
    rivals = [f for f in step.ranked if f.candidate.joint == joint and counts(view, f)]
    rivals = [f for f in rivals if f is again or owns(view, f, region_of(view, f.candidate))]
    free = (f for f in rivals if f.candidate.family not in named)
    best = next((f for f in free if f is again or not admission(view, f, [f.candidate], held).reason), again)
    return view.led_by(best, step.ranked)
