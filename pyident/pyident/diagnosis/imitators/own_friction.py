"""Whether each log's own friction and zeros do what a load that one log carries is named for.

Torque sensors and currents are zeroed anew before a log, and friction is another on a cold morning. A small
mass that hangs on the arm in one log alone shifts the torques of this log, too, and may be named for these.
"""

from collections.abc import Sequence

from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import extended, joined
from pyident.diagnosis.search.search import Search


def friction_of_each_log(robot: Robot, joint: int, count: int) -> list[Candidate]:
    """How the friction of a joint (from 1), its torque's zero and the drift of this differ in every one of so
    many logs from the first; and the zero and its drift in all, where the model has none."""
    return _of_each_log(robot, joint, count, ("coulomb", "viscous"))


def zeros_of_each_log(robot: Robot, joint: int, count: int) -> list[Candidate]:
    """The same of the torque's zero and its drift alone."""
    return _of_each_log(robot, joint, count, ())


def _of_each_log(robot: Robot, joint: int, count: int, friction: Sequence[str]) -> list[Candidate]:
    present = robot.joints[joint - 1].values
    names = [name for name in (*friction, "offset") if name in present]
    lacking = [name for name in ("offset", "offset_drift") if name not in present]
    found = [Candidate(name, joint, log=log) for log in range(1, count) for name in (*names, *lacking)]
    return [*found, *(Candidate(name, joint) for name in lacking)] if found else []


def told_by_friction(whole: Search, candidate: Candidate) -> bool:
    """Whether a candidate of one log takes little beside such friction of the joints where it acts, and this
    explains as much as the candidate does: it has several times the parameters."""
    if candidate.log is None:
        return False
    count = len(whole.examination.logs)
    rows = whole.rows(candidate)
    joints = sorted({whole.robot.q[row].joint for row in rows})
    listed = [c for k in joints for c in friction_of_each_log(whole.robot, k, count)]
    if not listed:
        return False
    rules, without = whole.rules, whole.without(candidate)
    beside = extended(without.base, joined([whole.columns(c) for c in listed]))
    taken = without.gain_of(candidate).energy
    if without.gain_of(candidate, beside).energy >= rules.apart * taken:
        return False
    before = without.remaining_on(rows)
    by_friction = before - whole.examination.beyond_floor(beside, rows)
    return by_friction >= rules.tie * (before - whole.remaining_on(rows))
