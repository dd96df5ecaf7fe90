"""Every question that tells an effect from what only stands in for another, asked one after the other."""

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.imitators.answer import answers
from pyident.diagnosis.imitators.breadth import rests_on
from pyident.diagnosis.imitators.constancy import changes_with
from pyident.diagnosis.imitators.imitation import stands_in_for
from pyident.diagnosis.imitators.modulation import grows_with
from pyident.diagnosis.imitators.own_friction import told_by_friction
from pyident.diagnosis.search.search import Search


def fault_of(whole: Search, candidate: Candidate) -> str:
    """Why a candidate only imitates, empty when it does not."""
    quantity = changes_with(whole, candidate)
    if quantity:
        return f"its coefficients change with {quantity}"
    signal = grows_with(whole, candidate)
    if signal:
        return f"its amplitude grows with {signal}"
    samples = rests_on(whole, candidate)
    if samples:
        return f"most of its gain rests on {samples}, where little of its force is"
    if answers(whole, candidate):
        return "a controller's answer to slow disturbances does the same"
    if told_by_friction(whole, candidate):
        return "each log's own friction and zeros do the same"
    words = stands_in_for(whole, candidate)
    return f"what it leaves depends on {words}, beside which it explains little" if words else ""
