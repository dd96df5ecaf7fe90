"""Whether a torque that comes late is a loop's answer to what slowly disturbs its joint.

Wind pushes an axis, and its controller pushes back a little later. So what is missing goes with the torque's
past by itself, and a drive that delivers late takes a part of it, in held-out logs as well. A drive's delay
leaves nothing: where the rest may be slow noise, which would have such an answer, a delay is not known of.
"""

from flexmodels.effects import signals
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.base.standing_out import bands_in_doubt
from pyident.diagnosis.search.gate import region_of
from pyident.diagnosis.search.search import Search


def follows_torque(robot: Robot, law: Candidate) -> bool:
    """Whether a law has a memory of the torque: it comes late."""
    return any(signals.tau in state.rate.free_symbols for state in law_of(robot, law).states)


def answers(whole: Search, candidate: Candidate) -> bool:
    """Whether a candidate that follows the torque leaves much, all of which slow noise may do.

    whole   rests on the candidate and all others that are named; where it knows the controller, replicas
            answer disturbances as the logs do
    """
    if whole.examination.setting.simulates or not follows_torque(whole.robot, candidate):
        return False
    region = region_of(whole.without(candidate), candidate)
    hardly = (1 - whole.rules.whole) * whole.excess_in(region)
    in_doubt = bands_in_doubt(whole.examination, whole.base)[list(region.rows)].any()
    return bool(in_doubt) and whole.remaining_in(region) > hardly
