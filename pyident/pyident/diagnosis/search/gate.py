"""The gate that an effect passes to be added to a model, or named, and the numbers by which it fails.

All shares are of what exceeds the floor on the equations where the effect acts: what another joint lacks says
nothing about this one. `admission` is the gate. Who passes it may be added; who takes most besides is named.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.effects import signals
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.base.projection import falls
from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.search.found import Found, Step, candidates_of
from pyident.diagnosis.search.held_out import HeldOut, Unseen
from pyident.diagnosis.search.measured import measured
from pyident.diagnosis.search.power import impossible
from pyident.diagnosis.search.same_order import same_order, without_periods
from pyident.diagnosis.search.search import Search
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.denoised import where_moving

_EXCHANGES = 4  # rounds; two are the rule


@dataclass(frozen=True)
class Refusal:
    """A candidate that explains most of what its equations lack, and is not named. Shares in percent.

    certain   whether held-out logs show beyond chance that it, or a set with it, is a part of what is missing
    """

    candidate: Candidate
    region: Region
    share_percent: float
    heldout_percent: float | None
    reason: str
    certain: bool = False


@dataclass(frozen=True)
class Admission:
    """What the gate finds of effects, `lead` first, in the `region` of a search where it acts.

    p_value   chance of the lead's gain with nothing missing
    measured  whether they are an error of the robot file that counts without a share (see `measured`)
    share     of what exceeds the floor there that all of them take;  unseen: the same on held-out logs
    reason    why they do not pass; empty: they do
    certain   as of a refusal
    """

    lead: Candidate
    region: Region
    p_value: float
    share: float
    unseen: Unseen | None
    reason: str
    measured: bool = False
    certain: bool = False

    @property
    def refusal(self) -> Refusal:
        unseen = None if self.unseen is None else 100 * self.unseen.share
        return Refusal(self.lead, self.region, 100 * self.share, unseen, self.reason, self.certain)


def admission(search: Search, lead: Found, candidates: Sequence[Candidate], held: HeldOut) -> Admission:
    """Whether effects, `lead` first, may be added to what the search rests on."""
    rules, region = search.rules, region_of(search, lead.candidate)
    p_value, share = search.p_value(lead), share_in(search, candidates, region)
    unseen = held.share(search, candidates, region)
    counted = lead.candidate.describes and measured(search, candidates[0], unseen)
    reason = ""
    if counted:
        pass
    elif p_value > rules.level:
        reason = without_periods(search, lead) or f"replicas without it show as much (p = {p_value:.2g})"
    elif (over := _over_floor(search, lead.candidate, region)) < rules.below_floor:
        reason = f"the residual lies below its floor there ({over:.2g} times), which hides what is smaller"
    elif not counts(search, lead):
        reason = "what it takes is too small beside the floor to matter"
    elif (driven := search.drives(candidates)) > rules.power:
        reason = impossible(search.robot, lead.candidate, driven)
    elif beyond_motion(search, lead.candidate):
        reason = "it takes only what lies beyond the motion, where a controller answers the encoders' noise"
    elif share < rules.part:
        reason = f"it takes {100 * share:.2g} % of what exceeds the floor there"
    elif unseen is not None:
        reason = _not_held(search, candidates, share, unseen, held)
    held_out = unseen is not None and unseen.deviations >= rules.chance
    return Admission(lead.candidate, region, p_value, share, unseen, reason, counted, held_out)


def beyond_motion(search: Search, candidate: Candidate) -> bool:
    """Whether hardly any of what a law of the motor's torque takes lies at frequencies of the joints' motion.

    Beyond these the torque that a model needs is the encoders' noise, twice differenced, and the torque that
    is measured may be a controller's answer to it: the one explains the other, late or early.
    """
    ex = search.examination
    if candidate.describes or signals.tau not in law_of(search.robot, candidate).symbols:
        return False
    moving = where_moving(search.robot, ex.setting.logs, ex.logs)
    fall = falls(search.base, search.columns(candidate))
    inside = sum(float(log[clear].sum()) for log, clear in zip(fall, moving, strict=True))
    return inside < search.rules.part * sum(float(log.sum()) for log in fall)


def _not_held(
    search: Search, candidates: Sequence[Candidate], share: float, unseen: Unseen, held: HeldOut
) -> str:
    """Why held-out logs do not bear out effects; empty: they do."""
    matters = unseen.of_floor(search.rules) >= search.rules.material
    if matters and held.holds(unseen, share, search.rules):
        return ""
    if len(candidates) == 1 and same_order(search, candidates[0], held):
        return ""
    chance = ", which may be chance" if unseen.share <= CONFIDENCE * unseen.std else ""
    why = chance if matters else ", too little beside the floor to matter"
    return f"on held-out data it takes {unseen}{why}"


def counts(search: Search, found: Found) -> bool:
    """Whether it is no chance and large enough to matter."""
    return search.p_value(
        found
    ) <= search.rules.level and found.excess >= search.rules.material * search.floor_energy_on(
        search.rows(found.candidate)
    )


def nothing_left(search: Search, region: Region) -> bool:
    """Whether a region hardly exceeds its floor: what takes it takes noise."""
    return search.remaining_in(region) < search.rules.material * search.floor_energy_on(region.rows)


def owns(search: Search, found: Found, region: Region) -> bool:
    """Whether it takes away most of what still exceeds the floor where it acts, and a part of what did.

    A small one must leave nothing there: beside an inexact law it may be that law's remainder. A constant has
    no form that could be inexact, so what it took does not count.
    """
    left, constants = search.remaining_in(region), [c for c in search.chosen if _constant(search, c)]
    if found.excess >= search.rules.part * search.resting_on(constants).remaining_in(region):
        return found.excess >= search.rules.own * left
    return found.excess >= search.rules.whole * left


def _constant(search: Search, candidate: Candidate) -> bool:
    """Whether it is a force that depends on nothing."""
    forces = law_of(search.robot, candidate).forces.values()
    return bool(forces) and all(force.free_symbols.isdisjoint(signals.ALL) for force in forces)


def _over_floor(search: Search, candidate: Candidate, region: Region) -> float:
    """rms of what is left over that of replicas in a region, band by band as a candidate takes of them.

    Replicas that are too noisy in a band say nothing about another.
    """
    ex, rows = search.examination, list(region.rows)
    fall = np.maximum(_fall(search, candidate)[rows].sum(axis=0), 0.0)
    left = ex.by_band(search.base.residual).sum(axis=0)[rows].sum(axis=0)
    floor = (ex.replica_energy.mean(axis=0) * ex.count)[rows].sum(axis=0)
    known = floor > 0
    return float(np.sqrt(np.average(left[known] / floor[known], weights=fall[known] + 1e-300)))


def _fall(search: Search, candidate: Candidate) -> np.ndarray:
    """(n, bands) energy that a candidate takes of what is left."""
    pairs = zip(falls(search.base, search.columns(candidate)), search.examination.bands, strict=True)
    return np.sum([log @ inside for log, inside in pairs], axis=0)


def region_of(search: Search, candidate: Candidate) -> Region:
    """The rows of which a candidate takes most of what it takes, and a part of what they lack; and the bands,
    from the lowest to the highest, in which it does. What shakes an arm at ten hertz says nothing about
    friction that changes once a second.
    """
    part, fall = search.rules.part, _fall(search, candidate)
    of_row = fall.sum(axis=1)
    matters = (of_row >= part * max(float(of_row.max()), 1e-300)) & (of_row >= part * search.lacking)
    matters[int(np.argmax(of_row))] = True
    in_band = fall[matters].sum(axis=0)
    bands = np.flatnonzero(in_band >= part * float(in_band.max()))
    bands = range(int(bands[0]), int(bands[-1]) + 1)
    return Region(tuple(int(row) for row in np.flatnonzero(matters)), tuple(bands))


def acting_region(without: Search, candidate: Candidate) -> Region:
    """All rows on which a candidate acts, in the bands in which it takes what a search without it lacks."""
    return replace(region_of(without, candidate), rows=tuple(without.rows(candidate)))


def share_in(search: Search, candidates: Sequence[Candidate], region: Region) -> float:
    """What further candidates take of what exceeds the floor in a region of the search."""
    before = search.remaining_in(region)
    after = search.with_further(candidates).remaining_in(region)
    return 1 - after / before if before > 0 else 1.0


def sets_for(
    search: Search, step: Step, lead: Found, held: HeldOut
) -> Iterator[tuple[list[Step], Refusal | None]]:
    """Sets of effects, of one, two and more, that may explain the lead's equations; and why one does not.

    What one effect takes alone is spoilt, on held-out logs first, by another that acts there too. So a set
    grows where it does not pass, and its effects are exchanged until none can be bettered beside the others.
    The search rests on what was accepted before; step: its ranking.
    """
    first = search.led_by(lead, [lead, *(f for f in step.ranked if f is not lead)])
    steps = [_taking_enough(search, first, search.rules.needed(1))]
    region = region_of(search, lead.candidate)
    for size in range(1, search.rules.together + 1):
        needed = search.rules.needed(size)
        entry = admission(search, steps[0].best, candidates_of(steps), held)
        if entry.share < needed:
            yield steps, _too_little(entry, needed)
        elif entry.reason:
            yield steps, entry.refusal
        else:
            yield steps, _not_each(search, steps, region, held)
        further = _next(search, steps, region)
        if further is None:
            return
        steps = _exchanged(search, [*steps, further], region)


def _taking_enough(search: Search, step: Step, needed: float) -> Step:
    """The step, led by the first of its tie that takes enough for a name; by its own where none does."""
    for found in step.tie:
        region = region_of(search, found.candidate)
        if share_in(search, [found.candidate], region) >= needed:
            others = (f for f in step.tie if f is not found)
            return replace(step, tie=(found, *others), p_value=search.p_value(found))
    return step


def _not_each(search: Search, steps: Sequence[Step], region: Region, held: HeldOut) -> Refusal | None:
    """The first of several effects that does not hold on held-out logs beside the others, if there is one."""
    if len(steps) < 2:
        return None
    for own in steps:
        view = search.with_further(candidates_of([s for s in steps if s is not own]))
        share, unseen = share_in(view, own.candidates, region), held.share(view, own.candidates, region)
        if unseen is not None and not held.holds(unseen, share, search.rules):
            reason = f"on held-out data it takes {unseen} of what the others leave"
            percent = 100 * unseen.share
            return Refusal(own.best.candidate, region, 100 * share, percent, reason)
    return None


def _next(search: Search, steps: Sequence[Step], region: Region) -> Step | None:
    """The best further effect on the same equations, if it takes enough."""
    found = _best_beside(search, steps, region)
    if found is None or found.best.excess < search.rules.part * search.remaining_in(region):
        return None
    return found


def _best_beside(search: Search, steps: Sequence[Step], region: Region) -> Step | None:
    """What takes most of a region beside a set, and counts."""
    beside = search.with_further(candidates_of(steps))
    step = beside.step(region.rows)
    named = {s.best.candidate.family for s in steps}
    for found in step.ranked:
        free = found.candidate.family not in named and _of_its_own(search, found.candidate)
        if free and counts(beside, found) and region_of(beside, found.candidate).meets(region):
            return beside.led_by(found, step.ranked)
    return None


def _of_its_own(search: Search, candidate: Candidate) -> bool:
    """Whether it is not what the search rests on already; a wave may be a further one."""
    same = [c for c in search.chosen if (c.effect, c.joint, c.log) == candidate.family[:3]]
    return not same or search.resolves([*same, candidate])


def _exchanged(search: Search, steps: Sequence[Step], region: Region) -> list[Step]:
    """The set with each of its effects replaced by what takes more beside the others, while any does."""
    out, left = list(steps), np.inf
    for _ in range(_EXCHANGES):
        for place in range(len(out)):
            better = _best_beside(search, [*out[:place], *out[place + 1 :]], region)
            if better is not None:
                out[place] = better
        before, left = left, search.with_further(candidates_of(out)).remaining_in(region)
        if not left < before:
            break
    return out


def _too_little(entry: Admission, needed: float) -> Refusal:
    """Of a lead that passes the gate or not, but takes too little for a name."""
    share = f"it takes {100 * entry.share:.0f} % of what exceeds the floor there"
    if entry.unseen is not None:
        share = f"{share}, {entry.unseen} on held-out data"
    return replace(entry, reason=f"{share}; a name needs {100 * needed:.0f} %").refusal
