"""Whether held-out logs show a ripple at its order, whatever its size and phase there.

In a loop, a ripple that is faster than the controller hardly shows in the torque that it commands: of what a
gear does, the loop answers the more the slower the joint turns, and late. So size and phase are those of
a log's speeds, and another log has others, but the same order. An order is a number that noise or another law
seldom hits: beside it, as far away as a log tells two orders apart, much less is found.
"""

import numpy as np

from pyident.diagnosis.base.candidates import Candidate, columns_of, law_of, width
from pyident.diagnosis.base.nonlinear_values import wants_no_period
from pyident.diagnosis.base.projection import gains
from pyident.diagnosis.search.found import Found
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search
from pyident.rules.confidence import PERIODS

_WITHIN = 1.5  # other orders are this many times smaller to larger
_TRIED = 61  # of them, beside it


def same_order(search: Search, candidate: Candidate, held: HeldOut) -> bool:
    """Of a periodic torque in a loop that is not known. The search rests on what acts beside it."""
    order = law_of(search.robot, candidate).order_of_torque
    if order is None or search.examination.setting.simulates or not held.equations:
        return False
    own = dict(candidate.values)[order.name]
    others = own * np.geomspace(1 / _WITHIN, _WITHIN, _TRIED)
    listed = [candidate, *(candidate.at({order.name: float(other)}) for other in others)]
    unbounded = np.full(width(search.robot, candidate), np.inf)
    free = [(-unbounded, unbounded)] * len(listed)
    energy, angle = np.zeros(len(listed)), 0.0
    for log, base in held.beside(search):
        level = search.examination.floor.at(log.band)
        X = list(columns_of(search.robot, listed, [log], [level]))
        energy += [found.energy for found in gains(base, X, free)]
        angle = max(angle, float(np.ptp(log.part.motion.q[:, candidate.joint - 1])))
    apart = np.abs(others - own) * angle >= 2 * np.pi
    if not apart.any():
        return False
    rules = search.rules
    return bool(energy[0] >= rules.chance**2 and energy[1:][apart].max() <= rules.apart * energy[0])


def without_periods(search: Search, lead: Found) -> str:
    """That a periodic torque fits best with fewer periods than make it one; empty: it has them."""
    if not wants_no_period(search.robot, lead.candidate, search.examination.candidates):
        return ""
    return f"the motion passes fewer than {PERIODS:g} periods of what fits best: so it is no ripple yet"
