"""A law as it acts at a joint: deformations that it has not are zero, and what vanishes is left out.

A hinge that only twists keeps k[1] of the stiffness, and no more.
"""

from dataclasses import replace
from functools import cache
from typing import Any

from flexmodels.effects import signals
from flexmodels.effects.effect import Effect


@cache
def restricted(effect: Effect, deformations: tuple[int, ...]) -> Effect:
    """The law at a joint with these of the deformations 1, 2, 3, without the parameters it no longer uses."""
    absent = [i for i in signals.eps if i not in deformations]
    gone: dict[Any, Any] = {s[i]: 0 for s in (signals.eps, signals.deps) for i in absent}
    if not absent or effect.symbols.isdisjoint(gone):
        return effect
    left = {q: law.subs(gone) for q, law in effect.forces.items() if q not in gone}
    forces = {q: law for q, law in left.items() if law != 0}
    states = tuple(replace(state, rate=state.rate.subs(gone)) for state in effect.states)
    smaller = replace(effect, forces=forces, states=states if forces else ())
    return replace(smaller, parameters=tuple(p for p in effect.parameters if p.symbol in smaller.symbols))


def objection(effect: Effect, deformations: tuple[int, ...], kind: str, k: int, joints: int) -> str | None:
    """Why the law cannot act at joint k of `joints`, to be read behind the effect's name; None: it can."""
    if effect.couples and k == joints:
        return f"couples a joint with the next one, and joint {k} is the last; put it at an earlier joint"
    if effect.body and k != joints:
        return f"is a body at the tip; put it at the last joint, {joints}"
    if effect.turning and kind == "prismatic":
        return f"belongs to a revolute joint, and joint {k} is prismatic; remove it"
    acting = restricted(effect, deformations)
    if not acting.forces and not acting.body:
        return f"acts on deformations that joint {k} has not; remove it"
    return None
