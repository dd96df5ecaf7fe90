"""Whether a law stands in for something else: what it leaves depends on a signal that it does not know.

Friction that grows with the bending of the next bearing looks like friction that grows with the load, in
part. What is left then is still a smooth function of that bending; such a function by itself leaves much less
than the law does, and with it in the base the law has little to explain. A true law that an unknown force
accompanies keeps what it explains beside it. Where a law of the catalogue takes most of what the function
does, nothing unknown is there: a constant torque is a part of some function of the speed, and so is the
friction beside it.
"""

from flexmodels.coordinate import signal_of
from flexmodels.effects import signals
from flexmodels.effects.effect import Effect
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.base.projection import extended
from pyident.diagnosis.search.gate import acting_region, region_of
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.unexplained.residual_terms import Dependence, RowSearch


def stands_in_for(search: Search, candidate: Candidate) -> str:
    """The dependence, in words, that a candidate imitates; empty when there is none.

    The search must rest on the candidate and all others that are named.
    """
    if candidate.log is not None:
        return ""
    without = search.without(candidate)
    region = acting_region(without, candidate)
    if search.remaining_in(region) <= search.rules.foreign_left * search.excess_in(region):
        return ""
    row = max(region.rows, key=lambda row: search.remaining_on([row]))
    left = search.remaining_on([row])
    found = RowSearch(search.examination, search.base, row, left).strongest()
    if found is None:
        return ""
    dependence, columns = found
    known = _known(law_of(search.robot, candidate), candidate.joint)
    if dependence.gain < search.rules.foreign_signal * left or not _foreign(dependence, known):
        return ""
    instead = extended(without.base, columns)
    if search.examination.beyond_floor(instead, [row]) > search.rules.foreign_richer * left:
        return ""
    by_itself, beside = (search.gain_of(candidate, base).energy for base in (without.base, instead))
    if beside >= search.rules.foreign_kept * by_itself or _has_a_name(search, row, dependence):
        return ""
    return dependence.said


def _has_a_name(search: Search, row: int, dependence: Dependence) -> bool:
    """Whether a law of the catalogue takes most of what the dependence takes of an equation."""
    least = search.rules.own * (dependence.gain - dependence.pretended)
    there = (f for f in search.step([row]).ranked if row in region_of(search, f.candidate).rows)
    return any(search.p_value(f) <= search.rules.level and f.excess >= least for f in there)


def _foreign(dependence: Dependence, known: frozenset[str]) -> bool:
    """Whether it is, and whatever explains nearly as much, of a signal that the law does not know."""
    return dependence.form == "misread" or known.isdisjoint((dependence.on, *dependence.rival_signals))


def _known(law: Effect, joint: int) -> frozenset[str]:
    """The names of a law's signals, of what follows from them included."""
    names = {str(s) for s in law.symbols & signals.ALL}
    if names & {"load", "eps1"}:
        names |= {"load", "eps1"}
    found = frozenset(signal_of(joint, name) for name in names)
    return found | {"travel"} if law.states else found
