"""Whether a periodic law's amplitude grows with a signal.

A ripple has one amplitude. A periodic torque that grows with the speed or the load is another law: one order
fits part of it, at a wrong number, and further orders take much of what is left, since along a motion that
comes back the speed is nearly a function of the angle. So the law is held against itself with an amplitude
a + b w, its order fitted anew, w the speed, the torque, the load or one of their squares. Such a law has
fewer parameters than two orders: where it leaves far less than one order does, further orders must leave far
less than it. Else the motion cannot tell them, and the law is not named. A ripple of one amplitude that is
faster than its sampling can follow falls with the speed; and one that leaves a tenth is a ripple, whatever it
does besides.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.coordinate import deformation_of
from pyident.diagnosis.base.candidates import Candidate, columns, law_of
from pyident.diagnosis.base.nonlinear_values import refined
from pyident.diagnosis.base.projection import Columns, extended, gain, joined
from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.imitators.constancy import QUANTITIES
from pyident.diagnosis.search.search import Search
from pyident.regression.loads.bodies import link_torques

_POWERS = {"{}": 1, "the square of the {}": 2}


def grows_with(search: Search, candidate: Candidate) -> str:
    """The signal that a periodic law's amplitude grows with, in words; empty when with none.

    The search must rest on the candidate with its further orders, and on all others that are named.
    """
    if law_of(search.robot, candidate).order is None:
        return ""
    rules, rows = search.rules, search.rows(candidate)
    view = search.resting_on([c for c in search.chosen if c.family != candidate.family])
    best = view.best(candidate.effect, candidate.joint)  # of one size at all speeds; none: no period is seen
    one = best.candidate if best else replace(candidate, speeds=())
    left = view.with_further([one]).remaining_on(rows)
    if left <= rules.part * search.excess_in(Region(tuple(rows))):
        return ""
    rivals = dict(_left_of_rivals(view, one, rows))
    words = min(rivals, key=lambda name: rivals[name], default="")
    if not words or rivals[words] >= rules.foreign_richer * left:
        return ""
    return "" if search.remaining_on(rows) < rules.foreign_richer * rivals[words] else words


def _left_of_rivals(view: Search, candidate: Candidate, rows: Sequence[int]) -> Iterator[tuple[str, float]]:
    """Signal -> what the law leaves on some equations with an amplitude that grows with it."""
    for signal, values in _sizes(view, candidate.joint):
        size = max(float(np.sqrt(np.mean(np.square(np.concatenate(values))))), 1e-300)
        for said, power in _POWERS.items():
            X = _best_under(view, candidate, [(v / size) ** power for v in values])
            own, more = np.split(gain(view.base, X).coefficients, 2)
            if np.linalg.norm(own + more) > np.linalg.norm(own):
                yield said.format(signal), view.examination.beyond_floor(extended(view.base, X), rows)


def _sizes(view: Search, joint: int) -> Iterator[tuple[str, list[np.ndarray]]]:
    """Signal -> per log (N,) its size. joint: from 1."""
    logs = view.examination.logs
    for signal in ("speed", "torque"):
        yield signal, [QUANTITIES[signal](view.robot, log, joint - 1) for log in logs]
    twist = deformation_of(joint)
    if twist in view.robot.coordinates:
        column = view.robot.coordinates.index(twist)
        yield "load", [np.abs(log.part.motion.q[:, column]) for log in logs]
    else:
        carried = (link_torques(view.robot, log.part.motion) for log in logs)
        yield "load", [np.abs(torques[:, joint - 1]) for torques in carried]


def _best_under(view: Search, candidate: Candidate, factors: Sequence[np.ndarray]) -> Columns:
    """Columns of a candidate's family as it is and times a factor, per log (N,), at its best values."""
    robot, logs, levels, listed = view.robot, view.examination.logs, view.levels, view.examination.candidates

    def made(c: Candidate) -> Columns:
        return joined([columns(robot, c, logs, levels), columns(robot, c, logs, levels, factors)])

    def explained(c: Candidate) -> float:
        return gain(view.base, made(c)).energy

    start = max((c for c in listed if c.family == candidate.family), key=explained)
    return made(refined(robot, start, listed, explained))
