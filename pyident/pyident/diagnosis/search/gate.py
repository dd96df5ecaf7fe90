"""The gate that an effect passes to be named, and the numbers by which it fails.

All shares are of what exceeds the floor on the equations where the effect acts: what another joint lacks says
nothing about this one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import fall_per_row
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Found, Search, Step


@dataclass(frozen=True)
class Refusal:
    """A candidate that explains most of what its equations lack, and is not named. Shares in percent."""

    candidate: Candidate
    rows: tuple[int, ...]
    share_percent: float
    heldout_percent: float | None
    reason: str


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
    rows = main_rows(search, lead.candidate)
    steps = [search.led_by(lead, [lead, *(f for f in step.ranked if f is not lead)])]
    shares: list[float] = []
    for needed in search.rules.explained:
        chosen = [s.best.candidate for s in steps]
        shares.append(share_on(search, chosen, rows))
        if shares[-1] >= needed:
            break
        further = _next(search, steps, rows)
        if further is None:
            return [], _refusal(search, steps[0], rows, shares[0], held, needed)
        steps.append(further)
    else:
        return [], _refusal(search, steps[0], rows, shares[0], held, search.rules.explained[0])
    chosen = [c for s in steps for c in s.candidates]
    unseen = held.share(search, chosen, rows)
    if unseen is not None and not held.holds(unseen, shares[-1], search.rules):
        reason = f"on held-out data it takes {100 * unseen.share:.0f} ± {100 * unseen.std:.0f} %"
        return [], Refusal(lead.candidate, rows, 100 * shares[-1], 100 * unseen.share, reason)
    return steps, None


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


def _refusal(
    search: Search, step: Step, rows: tuple[int, ...], share: float, held: HeldOut, needed: float
) -> Refusal:
    unseen = held.share(search, [step.best.candidate], rows)
    reason = (
        f"it takes {100 * share:.0f} % of what exceeds the floor there; a name needs {100 * needed:.0f} %"
    )
    return Refusal(
        step.best.candidate, rows, 100 * share, None if unseen is None else 100 * unseen.share, reason
    )
