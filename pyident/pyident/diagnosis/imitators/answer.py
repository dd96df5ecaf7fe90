"""Whether a torque that comes late is a loop's answer to what slowly disturbs its joint.

Wind pushes an axis, and its controller pushes back a little later. So what is missing goes with the torque's
past by itself, and a drive that delivers late takes a part of it, in held-out logs as well. A drive's delay
leaves nothing: where the rest may be slow noise, which would have such an answer, a delay is not known of.
"""

from flexmodels.effects import signals
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.base.standing_out import bands_in_doubt
from pyident.diagnosis.search.gate import region_of
from pyident.diagnosis.search.search import Search


def answers(whole: Search, candidate: Candidate) -> bool:
    """Whether a candidate that follows the torque leaves much, all of which slow noise may do.

    whole   rests on the candidate and all others that are named; where it knows the controller, replicas
            answer disturbances as the logs do
    """
    states = law_of(whole.robot, candidate).states
    if whole.examination.setting.simulates or not any(signals.tau in s.rate.free_symbols for s in states):
        return False
    region = region_of(whole.without(candidate), candidate)
    hardly = (1 - whole.rules.whole) * whole.excess_in(region)
    in_doubt = bands_in_doubt(whole.examination, whole.base)[list(region.rows)].any()
    return bool(in_doubt) and whole.remaining_in(region) > hardly
