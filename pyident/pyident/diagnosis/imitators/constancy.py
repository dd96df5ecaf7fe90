"""Whether a law's coefficients are the same throughout: an imitator's are not.

An effect that stands in for another may explain much of a residual, but with other coefficients when the
joint is fast than when it is slow, under much torque than under little, early than late. So the law is split
at the median of such a quantity into two halves with coefficients of their own (Chow 1960); one that itself
is a course of time, into quarters. What a true law gains by that is chance.

Friction warms up within a log. Then a law of it, which hardly differs from what friction the model has, gains
by halves of time what that friction gains by them: it is judged beside the model's friction, split likewise.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexmodels.effects import signals
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, columns, law_of, with_model_torque
from pyident.diagnosis.base.projection import extended, gain, joined
from pyident.diagnosis.search.gate import acting_region
from pyident.diagnosis.search.power import is_friction
from pyident.diagnosis.search.search import Search
from pyident.regression.spectrum import Equations

Quantity = Callable[[Robot, Equations, int], np.ndarray]


def _torque(robot: Robot, log: Equations, joint: int) -> np.ndarray:
    """The model's: samples chosen by the measured one are chosen by its noise, which bends coefficients."""
    tau = with_model_torque(robot, log.part.motion).tau
    assert tau is not None
    return np.abs(tau[:, joint])


def _time(_: Robot, log: Equations, __: int) -> np.ndarray:
    return np.arange(len(log.part.target), dtype=float)


QUANTITIES: dict[str, Quantity] = {
    "speed": lambda _, log, joint: np.abs(log.part.motion.dq[:, joint]),
    "torque": _torque,
    "position": lambda _, log, joint: log.part.motion.q[:, joint],
    "direction": lambda _, log, joint: np.sign(log.part.motion.dq[:, joint]),
    "time": _time,
}
_OF_SPEED = ("speed", "direction")  # of which a law that answers has coefficients of its own
_FRICTION = ("coulomb", "viscous")
_MEDIAN = (0.5,)
_QUARTERS = (0.25, 0.5, 0.75)  # a law of time is split finer: a step has half of a drift's course in common


def changes_with(search: Search, candidate: Candidate) -> str:
    """The quantity that the coefficients of a candidate change with most, empty when they do not.

    The search must rest on the candidate and all others that are named.
    """
    if candidate.log is not None:
        return ""  # a body's parameters cannot change within a log
    least = search.rules.changes * _to_gain(search, candidate)
    worst = _most_changed(search, candidate, least)
    warmed = _beside_warming(search, candidate) if worst else None
    return worst if warmed is None else _most_changed(warmed, candidate, least)


def _most_changed(search: Search, candidate: Candidate, least: float) -> str:
    """The quantity whose halves gain most, if this is more than a least energy; else empty."""
    asked = {name: q for name, q in QUANTITIES.items() if not (candidate.speeds and name in _OF_SPEED)}
    gained = {name: _gained(search, candidate, quantity) for name, quantity in asked.items()}
    worst = max(gained, key=lambda name: gained[name])
    return worst if gained[worst] > least else ""


def _beside_warming(search: Search, candidate: Candidate) -> Search | None:
    """The search whose joint has another friction in the second half of every log; None for what is no law of
    friction, or takes little beside that.
    """
    robot, logs, joint = search.robot, search.examination.logs, candidate.joint
    present = [name for name in _FRICTION if name in robot.joints[joint - 1].values]
    if not present or not is_friction(robot, candidate):
        return None
    late = above_median(search, joint, _time)
    X = joined([columns(robot, Candidate(name, joint), logs, search.levels, late) for name in present])
    without = search.without(candidate)
    kept = without.gain_of(candidate, extended(without.base, X)).energy
    if kept < search.rules.apart * without.gain_of(candidate).energy:
        return None
    return replace(search, base=extended(search.base, X))


def _gained(search: Search, candidate: Candidate, quantity: Quantity) -> float:
    """Energy that coefficients of their own above the median take."""
    logs, parts = search.examination.logs, _MEDIAN
    if quantity is _time and signals.time in law_of(search.robot, candidate).symbols:
        parts = _QUARTERS
    above = [above_quantile(search, candidate.joint, quantity, part) for part in parts]
    X = joined([columns(search.robot, candidate, logs, search.levels, high) for high in above])
    return gain(search.base, X).energy


def _to_gain(search: Search, candidate: Candidate) -> float:
    """What exceeds the floor where a law acts; where that is less than what the law itself takes, as a floor
    that is too high at other frequencies makes it, the latter.
    """
    without = search.without(candidate)
    own = without.gain_of(candidate).energy
    return max(search.excess_in(acting_region(without, candidate)), own, 1e-300)


def above_median(search: Search, joint: int, quantity: Quantity) -> list[np.ndarray]:
    """Per log (N,): 1 where a joint's quantity lies above its median over all logs, else 0. joint: from 1."""
    return above_quantile(search, joint, quantity, 0.5)


def above_quantile(search: Search, joint: int, quantity: Quantity, share: float) -> list[np.ndarray]:
    """Per log (N,): the same of the quantile `share`."""
    values = [quantity(search.robot, log, joint - 1) for log in search.examination.logs]
    least = np.quantile(np.concatenate(values), share)
    return [(v > least).astype(float) for v in values]
