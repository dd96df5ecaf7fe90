"""How many effects are named: the fewest that explain most of the excess, then those that stand alone.

A set is looked for first, one effect, then two ... that takes away most of the excess. Once there is one, a
further effect must take away most of what still exceeds the floor on its own equations: what an inexact law
leaves behind is shared among many candidates, a true effect is taken by one. At last a law whose coefficients
change over the logs is dropped, and one that leaves what depends on a signal that it does not know: they
stand in for something else (see `constancy`, `imitation`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.search.constancy import changes_with
from pyident.diagnosis.search.imitation import stands_in_for
from pyident.diagnosis.search.search import Found, Search, Step


@dataclass(frozen=True)
class Selection:
    """What was selected.

    steps      one per effect, each ranked with all others in the base
    explained  share of the excess after the first of them, the first two ...
    first      the ranking with none selected
    imitators  what was dropped: effect and joint -> why
    """

    steps: tuple[Step, ...]
    explained: tuple[float, ...]
    first: Step
    imitators: dict[str, str]

    @property
    def candidates(self) -> list[Candidate]:
        return _candidates(self.steps)


def select(search: Search) -> Selection:
    """What a search comes to, whatever it rests on."""
    search = search.resting_on(())
    first = search.step()
    chosen, imitators = _constant(search, _explaining(search, first))  # before others can cover a change
    if chosen:
        chosen = _judged_together(search, _standing(search, _with_orders(search, chosen)))
    chosen, more = _constant(search, chosen)
    chosen, others = _of_its_own(search, chosen)
    imitators |= more | others
    explained = []
    for n in range(len(chosen)):
        explained.append(search.resting_on(_candidates(chosen[: n + 1])).explained)
    return Selection(tuple(chosen), tuple(explained), first, imitators)


def _explaining(search: Search, step: Step) -> list[Step]:
    """The smallest set that explains enough, empty when there is none."""
    steps: list[Step] = []
    for needed in search.rules.explained:
        if not (_counts(search, step.best) and step.best.excess >= search.rules.part * search.excess):
            return []
        steps.append(step)
        search = search.resting_on([s.best.candidate for s in steps])
        if search.explained >= needed:
            return steps
        step = search.step()
    return []


def _candidates(steps: Sequence[Step]) -> list[Candidate]:
    return [c for step in steps for c in step.candidates]


def _with_orders(search: Search, steps: Sequence[Step]) -> list[Step]:
    """Periodic laws with their further orders, else these would hide what else is missing."""
    out = list(steps)
    for i, step in enumerate(steps):
        law, joint = law_of(search.robot, step.best.candidate), step.best.candidate.joint
        if not any(p.name == "order" for p in law.nonlinear):
            continue
        others = _candidates([s for s in out if s is not out[i]])
        orders = [step.best.candidate]
        for _ in range(search.rules.orders):
            search = search.resting_on([*others, *orders])
            more = search.best(law.name, joint)
            if more is None or not (_counts(search, more) and _takes(search, more, search.rules.order)):
                break
            orders = _refitted(search, others, [*orders, more.candidate])
        search = search.resting_on([*others, *orders[1:]])
        main = search.best(law.name, joint)
        out[i] = replace(step, tie=(main or step.best, *step.tie[1:]), orders=tuple(orders[1:]))
    return out


def _refitted(search: Search, others: Sequence[Candidate], orders: Sequence[Candidate]) -> list[Candidate]:
    """Each order again with the rest in the base: the first was found beside what the others now take."""
    out = list(orders)
    for i, order in enumerate(orders):
        search = search.resting_on([*others, *out[:i], *out[i + 1 :]])
        again = search.best(order.effect, order.joint)
        out[i] = again.candidate if again else order
    return out


def _standing(search: Search, steps: list[Step]) -> list[Step]:
    """With the further effects that stand by themselves, where all together explain enough."""
    while len(steps) < search.rules.most:
        search = search.resting_on(_candidates(steps))
        step = search.step()
        named = {f.candidate.family for s in steps for f in s.tie}
        others = [f for f in step.ranked if f.candidate.family not in named and _counts(search, f)]
        allowed = search.remaining - (1 - search.rules.explained[-1]) * search.excess
        further = next((f for f in others if f.excess >= allowed and _owns(search, f)), None)
        if further is None:
            return steps
        steps = [*steps, search.led_by(further, step.ranked)]
    return steps


def _judged_together(search: Search, steps: Sequence[Step]) -> list[Step]:
    """Each effect ranked again with the others in the base; those that others have made needless are gone."""
    kept, out = list(steps), []
    for old in steps:
        others = [s for s in kept if s is not old]
        search = search.resting_on([*_candidates(others), *old.orders])
        step, family = search.step(), old.best.candidate.family
        again = next((f for f in step.ranked if f.candidate.family == family), None)
        if again is None or not _counts(search, again):
            kept.remove(old)
            continue
        named = {s.best.candidate.family for s in others}
        rivals = [f for f in step.ranked if f.candidate.joint == again.candidate.joint and _counts(search, f)]
        rivals = [f for f in rivals if f is again or _owns(search, f)]
        best = next(f for f in rivals if f.candidate.family not in named)
        orders = old.orders if best.candidate.family == family else ()
        new = replace(search.led_by(best, step.ranked), orders=orders)
        kept[kept.index(old)] = new
        out.append(new)
    return out


def _constant(search: Search, steps: Sequence[Step]) -> tuple[list[Step], dict[str, str]]:
    """Those whose coefficients stay the same, if they explain enough; and what the others' change with."""

    whole = search.resting_on(_candidates(steps))

    def changing(candidate: Candidate) -> str:
        quantity = changes_with(whole, candidate)
        return f"its coefficients change with {quantity}" if quantity else ""

    return _without(search, steps, changing)


def _of_its_own(search: Search, steps: Sequence[Step]) -> tuple[list[Step], dict[str, str]]:
    """Those that stand in for nothing else, if they explain enough; and what the others stand in for."""

    whole = search.resting_on(_candidates(steps))

    def imitated(candidate: Candidate) -> str:
        words = stands_in_for(whole, candidate)
        return f"what it leaves depends on {words}, beside which it explains little" if words else ""

    return _without(search, steps, imitated)


def _without(
    search: Search, steps: Sequence[Step], fault: Callable[[Candidate], str]
) -> tuple[list[Step], dict[str, str]]:
    """Those without a fault, if they explain enough; and the faults of the others."""
    found = {i: step.best.candidate for i, step in enumerate(steps)}
    faults = {i: fault(c) for i, c in found.items()}
    kept = [step for i, step in enumerate(steps) if not faults[i]]
    needed = search.rules.explained
    if (
        len(kept) < len(steps)
        and search.resting_on(_candidates(kept)).explained < needed[min(len(kept), len(needed)) - 1]
    ):
        kept = []
    return kept, {f"{found[i].effect} at joint{found[i].joint}": why for i, why in faults.items() if why}


def _counts(search: Search, found: Found) -> bool:
    return (
        search.p_value(found) <= search.rules.level
        and found.excess >= search.rules.material * search.floor_energy
    )


def _owns(search: Search, found: Found) -> bool:
    """Whether it takes away most of what still exceeds the floor on its equations, and a part of what did.

    A small one must leave nothing anywhere: beside an inexact law it may be that law's remainder.
    """
    if found.excess >= search.rules.part * search.excess_on(search.rows(found.candidate)):
        return _takes(search, found, search.rules.own)
    return found.excess >= search.rules.whole * search.remaining


def _takes(search: Search, found: Found, share: float) -> bool:
    """Whether it takes this share of what still exceeds the floor on its equations."""
    return found.excess >= share * search.remaining_on(search.rows(found.candidate))
