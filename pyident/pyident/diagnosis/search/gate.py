"""The gate that an effect passes to be added to a model, or named, and the numbers by which it fails.

All shares are of what exceeds the floor on the equations where the effect acts: what another joint lacks says
nothing about this one. `admission` is the gate. Who passes it may be added; who takes most besides is named.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import fall_per_row
from pyident.diagnosis.search.held_out import HeldOut, Unseen
from pyident.diagnosis.search.search import Found, Search, Step


@dataclass(frozen=True)
class Refusal:
    """A candidate that explains most of what its equations lack, and is not named. Shares in percent."""

    candidate: Candidate
    rows: tuple[int, ...]
    share_percent: float
    heldout_percent: float | None
    reason: str


@dataclass(frozen=True)
class Admission:
    """What the gate finds of effects, `lead` first, on the equations `rows` of a search.

    p_value   chance of the lead's gain with nothing missing
    share     of what exceeds the floor there that all of them take;  unseen: the same on held-out logs
    reason    why they do not pass; empty: they do
    """

    lead: Candidate
    rows: tuple[int, ...]
    p_value: float
    share: float
    unseen: Unseen | None
    reason: str

    @property
    def refusal(self) -> Refusal:
        unseen = None if self.unseen is None else 100 * self.unseen.share
        return Refusal(self.lead, self.rows, 100 * self.share, unseen, self.reason)


def admission(search: Search, lead: Found, candidates: Sequence[Candidate], held: HeldOut) -> Admission:
    """Whether effects, `lead` first, may be added to what the search rests on."""
    rules, rows = search.rules, main_rows(search, lead.candidate)
    p_value, share = search.p_value(lead), share_on(search, candidates, rows)
    unseen = held.share(search, candidates, rows)
    reason = ""
    if p_value > rules.level:
        reason = f"replicas without it show as much (p = {p_value:.2g})"
    elif not counts(search, lead):
        reason = "what it takes is too small beside the floor to matter"
    elif (driven := search.drives(candidates)) > rules.power:
        reason = f"the joint's friction would drive it: it puts in {100 * driven:.0f} % of what it takes"
    elif share < rules.part:
        reason = f"it takes {100 * share:.2g} % of what exceeds the floor there"
    elif unseen is not None and not held.holds(unseen, share, rules):
        reason = f"on held-out data it takes {unseen}"
    return Admission(lead.candidate, rows, p_value, share, unseen, reason)


def counts(search: Search, found: Found) -> bool:
    """Whether it is no chance and large enough to matter."""
    return search.p_value(
        found
    ) <= search.rules.level and found.excess >= search.rules.material * search.floor_energy_on(
        search.rows(found.candidate)
    )


def main_rows(search: Search, candidate: Candidate) -> tuple[int, ...]:
    """The equations on which a candidate takes most of what it takes."""
    fall = fall_per_row(search.base, search.columns(candidate))
    rows = np.flatnonzero(fall >= search.rules.part * max(float(fall.max()), 1e-300))
    return tuple(int(row) for row in rows)


def share_on(search: Search, candidates: Sequence[Candidate], rows: Sequence[int]) -> float:
    """What further candidates take of what exceeds the floor on some equations of the search."""
    before = search.remaining_on(rows)
    after = search.with_further(candidates).remaining_on(rows)
    return 1 - after / before if before > 0 else 1.0


def group_for(search: Search, step: Step, lead: Found, held: HeldOut) -> tuple[list[Step], Refusal | None]:
    """The smallest set of effects, `lead` first, that explains its equations; else why there is none.

    The search rests on what was accepted before; step: its ranking.
    """
    steps = [search.led_by(lead, [lead, *(f for f in step.ranked if f is not lead)])]
    first = None
    for needed in search.rules.explained:
        entry = admission(search, lead, [c for s in steps for c in s.candidates], held)
        first = first or entry
        if entry.share >= needed:
            return (steps, None) if not entry.reason else ([], entry.refusal)
        further = _next(search, steps, entry.rows)
        if further is None:
            return [], _too_little(first, needed)
        steps.append(further)
    assert first is not None
    return [], _too_little(first, search.rules.explained[0])


def _next(search: Search, steps: Sequence[Step], rows: Sequence[int]) -> Step | None:
    """The best further effect on the same equations."""
    beside = search.with_further([s.best.candidate for s in steps])
    step = beside.step()
    named = {s.best.candidate.family for s in steps}
    for found in step.ranked:
        acts = set(main_rows(beside, found.candidate)) & set(rows)
        if acts and found.candidate.family not in named and counts(beside, found):
            if found.excess < search.rules.part * search.remaining_on(rows):
                return None
            return beside.led_by(found, step.ranked)
    return None


def _too_little(entry: Admission, needed: float) -> Refusal:
    """Of a lead that passes the gate or not, but takes too little for a name."""
    share = f"it takes {100 * entry.share:.0f} % of what exceeds the floor there"
    if entry.unseen is not None:
        share = f"{share}, {entry.unseen} on held-out data"
    return replace(entry, reason=f"{share}; a name needs {100 * needed:.0f} %").refusal
