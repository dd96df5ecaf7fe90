"""Friction that is another in every log: a robot warms up, is greased, or is logged again months later.

All logs share the model's parameters. What temperature makes of friction between two logs is then left in
both, at every joint at once, and no law of the catalogue is it. So where something stands out, every joint
whose friction differs from log to log gets its own in each of them (levels, slopes and offsets), and the
laws are put to what that leaves. Within a log friction must be friction: differences whose coefficients
change with the speed, the torque, the position or the direction stand in for something else, as in
`constancy`. And where a joint is fast in one log and slow in another, friction that is not quite the model's
is another in each, though nothing but the speed has changed: there only the torque's zero is asked about.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.coordinate import joint_number
from flexmodels.effects import CATALOGUE
from flexmodels.joint import parameter_name
from pyident.diagnosis.base.candidates import Candidate, bounds, columns, units_of
from pyident.diagnosis.base.projection import Columns, extended, gain, gains, gains_over, joined, others_of
from pyident.diagnosis.imitators.constancy import QUANTITIES, above_median
from pyident.diagnosis.imitators.own_friction import friction_of_each_log, zeros_of_each_log
from pyident.diagnosis.search.search import Search, search_of

_FASTER = 2.0  # times: rms speeds of a joint that are further apart have no friction in common
_SURE = 3.0  # standard deviations
_ZERO = (".offset", ".offset_drift.rate")  # of a torque, not friction
_WITHIN = ("speed", "torque", "position", "direction")  # friction that warms up changes with time


@dataclass(frozen=True)
class FrictionByLog:
    """What differs between logs.

    search       among all candidates, every log with its own friction at these joints
    joints       at which it does, from 1
    candidates   how the friction of these differs in every log but the first; a zero and a drift in all
    """

    search: Search
    joints: tuple[int, ...]
    candidates: tuple[Candidate, ...]

    def sentence(self, beside: Search) -> str:
        """Whose friction differs, and of whom only the torque's zero. beside: as of `differences`."""
        names = self.differences(beside)
        dry = sorted({joint_number(name) for name in names if not name.endswith(_ZERO)})
        zero = sorted({joint_number(name) for name in names} - set(dry))
        told = [f"the friction of {_joints(dry)}"] if dry else []
        told += [f"the zero of the torque of {_joints(zero)}"] if zero else []
        what = " and ".join(told)
        differs = "differs" if len(told) == 1 else "differ"
        return f"{what[0].upper()}{what[1:]} {differs} from log to log. With its own in every log:"

    def differences(self, beside: Search) -> dict[str, list[float]]:
        """Parameter -> per fitted log but the first how much more it is than there, in the parameter's unit.

        Of those that differ beyond chance in one log at least.

        beside   the search without this friction, which rests on what was named
        """
        found = gain(beside.base, joined([beside.columns(c) for c in self.candidates]))
        pairs = zip(found.coefficients.tolist(), found.std.tolist(), strict=True)
        out: dict[str, list[float]] = {}
        sure: set[str] = set()
        for c, (x, std) in zip(self.candidates, pairs, strict=True):
            if c.log is None:
                continue
            name = _named(c.effect, c.joint)
            out.setdefault(name, []).append(x)
            if abs(x) > _SURE * std:
                sure.add(name)
        return {name: values for name, values in out.items() if name in sure or not sure}

    def note(self, beside: Search) -> str:
        """By how much, and what to do. beside: as of `differences`."""
        robot, first = self.search.robot, self.search.examination.setting.logs[0].source
        own = {_named(c.effect, c.joint): c for c in self.candidates}
        units = {name: units_of(robot, c)[name.rpartition(".")[2]] for name, c in own.items()}
        each = []
        for name, others in self.differences(beside).items():
            ends = dict.fromkeys(f"{x:+.2g}" for x in (min(others), max(others)))
            each.append(f"{name} by {' to '.join(ends)} {units[name]}")
        return (
            f"against {first} the other logs differ in {', '.join(each)}: temperature does that, grease, or "
            "time; record with the robot warm and the torques' zeros set anew, or fit each log by itself, as "
            "a model has one value for all"
        )


def _named(effect: str, joint: int) -> str:
    """Of its one parameter."""
    return parameter_name(joint, effect, CATALOGUE[effect].linear[0].name)


def _joints(numbers: Sequence[int]) -> str:
    *most, last = [str(k) for k in numbers]
    return f"joints {', '.join(most)} and {last}" if most else f"joint {last}"


def friction_by_log(search: Search, named: Sequence[Candidate] = ()) -> FrictionByLog | None:
    """None where one log is fitted, or no joint's friction differs. The search must rest on nothing.

    named   without such friction; a body among these that one log carries loads joints in this log alone,
            and beside it no friction is looked for in its place
    """
    ex = search.examination
    beside = search.with_further([c for c in named if c.log is not None])
    joints = [k for k, _ in search.robot.numbered if _differs(beside, k)]
    if not joints:
        return None
    listed = [c for k in joints for c in _of_each_log(search, k)]
    wider = search.with_further(listed).base
    limits = [bounds(search.robot, c) for c in ex.candidates]
    own = replace(ex, base=wider, gains=gains(wider, ex.columns, limits))
    return FrictionByLog(search_of(own), tuple(joints), tuple(listed))


def _differs(search: Search, joint: int) -> bool:
    """Whether a joint's own friction in each log takes most of what stands out there.

    What slow noise may leave is another in every log as well.
    """
    rules, ex, base = search.rules, search.examination, search.base
    listed = _of_each_log(search, joint)
    row = joint - 1
    left = search.remaining_on([row])
    if not listed or left <= 0 or not search.standing_out[row]:
        return False
    X = joined([search.columns(c) for c in listed])
    free = (np.full(len(listed), -np.inf), np.full(len(listed), np.inf))
    taken = gain(base, X).energy
    if taken <= max(gains_over(base, X, others_of(base, ex.replica_residuals), *free)):
        return False
    beside = extended(base, X)
    share = 1 - ex.beyond_floor(beside, [row]) / left
    return share >= rules.explained[0] and all(
        gain(beside, _split(search, listed, name)).energy <= rules.changes * left for name in _WITHIN
    )


def _of_each_log(search: Search, joint: int) -> list[Candidate]:
    """What a joint may have of its own in each log, as far as its speeds let it be told."""
    logs = search.examination.logs
    speeds = [float(np.sqrt(np.mean(log.part.motion.dq[:, joint - 1] ** 2))) for log in logs]
    alike = max(speeds) <= _FASTER * min(speeds)
    return (friction_of_each_log if alike else zeros_of_each_log)(search.robot, joint, len(logs))


def _split(search: Search, listed: Sequence[Candidate], quantity: str) -> Columns:
    """The columns of friction in every log where a quantity lies above its median."""
    high = above_median(search, listed[0].joint, QUANTITIES[quantity])
    return joined([columns(search.robot, c, search.examination.logs, search.levels, high) for c in listed])
