"""Whether what a law takes may be the remainder of another one, named before, whose form is not quite right.

A periodic torque with wrong values leaves waves of its own frequencies, and another law beside it leaves what
is slow. Of an equation's frequencies the remainder can have no more, in all, than is left there. Taking it to
be spread as the law's own force, the most of a further law's force that it can be is

    share = Σ min(s², λ a²) / Σ s²,      λ = what is left / Σ a²,

where s and a are what the further law and the one before take at each frequency. A spring or a hose of
another form is the exception: what it leaves has multiples of the motion's frequencies, and is a function of
the angle as a ripple of few periods is.
"""

from collections.abc import Sequence

import numpy as np

from flexmodels.effects import signals
from pyident.conditioning.order_waves import span_of
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.base.projection import Base, extended
from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.search.found import Step
from pyident.diagnosis.search.search import Search

_ANGLES = frozenset({signals.e, *signals.eps.values()})
_FEW = 10.0  # periods: no hose bends as often


def may_be_remainder(search: Search, law: Candidate, before: Step, region: Region) -> bool:
    """Whether most of what `law` takes of a region may be what `before`, on which the search rests, leaves.

    Of laws that are no waves the remainder has another spectrum than the law, so it may be anything.
    """
    if not (_waves(search, law) or _waves(search, before.best.candidate)) or _bent(search, law, before):
        return True
    within = region.within(search.examination.bands)
    s = _taken(search.base, extended(search.base, search.columns(law)), within)
    without = search.resting_on([c for c in search.chosen if c not in before.candidates])
    a = _taken(without.base, search.base, within)
    remainder = min(search.remaining_in(region) / max(a.sum(), 1e-300), 1.0) * a
    return bool(np.minimum(s, remainder).sum() > (1 - search.rules.own) * s.sum())


def _bent(search: Search, wave: Candidate, spring: Step) -> bool:
    """Whether one is a wave of few periods, the other a force of the same joint's angle alone."""
    order, there = law_of(search.robot, wave).order_of_torque, spring.best.candidate
    forces = law_of(search.robot, there).forces.values()
    known = frozenset().union(*(force.free_symbols for force in forces)) & signals.ALL
    if order is None or _waves(search, there) or there.joint != wave.joint or known - _ANGLES or not known:
        return False
    angles = [log.part.motion.q[:, wave.joint - 1] for log in search.examination.logs]
    return dict(wave.values)[order.name] * span_of(angles) < _FEW * 2 * np.pi


def _waves(search: Search, candidate: Candidate) -> bool:
    return law_of(search.robot, candidate).order_of_torque is not None


def _taken(before: Base, after: Base, within: Sequence[tuple[np.ndarray, ...]]) -> np.ndarray:
    """Energy of what a wider base takes at each equation within every log, one log after the other."""
    each = zip(before.residual, after.residual, within, strict=True)
    return np.concatenate([np.square(b - a)[i].ravel() for b, a, i in each])
