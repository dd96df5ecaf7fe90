"""Further orders of a periodic law: a ripple seldom has one.

Two orders are two only where the motion resolves them, with a whole period of their difference within the
angle that the joint passes (Rayleigh); and an order that does not pass a period itself is a slow change over
the range. Closer waves beat, and the beat follows whatever changes along the range: they would imitate an
amplitude that grows with the speed. Where another law takes more, it comes first.
"""

from collections.abc import Sequence
from dataclasses import replace

from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.base.order_peaks import orders_told
from pyident.diagnosis.search.found import Found, Step, candidates_of
from pyident.diagnosis.search.gate import counts
from pyident.diagnosis.search.search import Search


def as_orders(chosen: Sequence[Step], further: Sequence[Step]) -> list[Step]:
    """All steps; a further wave of a periodic law that was chosen already is one of its orders."""
    waves = {s.best.candidate.family: s.candidates for s in further}
    named = {s.best.candidate.family for s in chosen}
    out = [replace(s, orders=(*s.orders, *waves.get(s.best.candidate.family, ()))) for s in chosen]
    return [*out, *(s for s in further if s.best.candidate.family not in named)]


def with_orders(search: Search, steps: Sequence[Step]) -> list[Step]:
    """Periodic laws with their further orders, else these would hide what else is missing."""
    out = list(steps)
    for i, step in enumerate(steps):
        if step.orders or law_of(search.robot, step.best.candidate).order is None:
            continue
        others = candidates_of([s for s in out if s is not out[i]])
        first, *further = _further(search, others, step.best.candidate)
        main = search.resting_on([*others, *further]).best(first.effect, first.joint, bool(first.speeds))
        out[i] = replace(step, tie=(main or step.best, *step.tie[1:]), orders=tuple(further))
    return out


def _further(search: Search, others: Sequence[Candidate], first: Candidate) -> list[Candidate]:
    """A periodic law's orders beside `others`, the first one first; a law without orders stays alone."""
    law = law_of(search.robot, first).order
    if law is None:
        return [first]
    orders = [first]
    for _ in range(search.rules.orders):
        view = search.resting_on([*others, *orders])
        more = view.best(first.effect, first.joint, bool(first.speeds))
        if more is None or not (counts(view, more) and _takes(view, more)) or _another(view, more):
            break
        wider = _refitted(search, others, [*orders, more.candidate])
        if not search.resolves(wider):
            break
        orders = wider
    return orders


def _refitted(search: Search, others: Sequence[Candidate], orders: Sequence[Candidate]) -> list[Candidate]:
    """Each order again with the rest in the base: the first was found beside what the others now take."""
    out = list(orders)
    for i, order in enumerate(orders):
        view = search.resting_on([*others, *out[:i], *out[i + 1 :]])
        again = view.best(order.effect, order.joint, bool(order.speeds))
        out[i] = again.candidate if again else order
    return out


def _takes(view: Search, found: Found) -> bool:
    """Whether it takes its share of what still exceeds the floor on its equations."""
    return found.excess >= view.rules.order * view.remaining_on(view.rows(found.candidate))


def _another(view: Search, found: Found) -> bool:
    """Whether another law takes more of the same equations: a low order imitates a spring, or a hose."""
    rows = set(view.rows(found.candidate))
    others = (f for f in view.step(sorted(rows)).ranked if f.candidate.effect != found.candidate.effect)
    return any(
        f.excess > found.excess and counts(view, f) and rows & set(view.rows(f.candidate)) for f in others
    )


def orders_of(robot: Robot, step: Step) -> str:
    """Further orders of a periodic law."""
    best = step.best.candidate
    more = orders_told(robot, best.joint, [dict(c.values)["order"] for c in step.orders])
    return f"{best.effect} at joint{best.joint} has further orders, counted with it: {more}."
