"""Coefficients of what is named: fitted together, each equation weighed by what all of it leaves there.

The search weighs an equation by what the model without any law leaves, so that a strong law makes its own
equation light, and intervals from there are wide by as much as the law stands above the floor.

Friction under the load of a rigid joint is a product of its coefficient and of the bodies that make the
load. The search has it at the loads of the bodies found, as if these were known. Here the bodies are fitted
with it, in rounds about the last values (see `LoadTangent`), so that an interval knows of the loads' error.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.effects import signals
from flexmodels.robot import Robot
from pyident.diagnosis.base.balance import raised_floors
from pyident.diagnosis.base.candidates import Candidate, bounds_of, columns, law_of, slopes, width
from pyident.diagnosis.base.carried_loads import whitened, with_bodies
from pyident.diagnosis.base.projection import Gain, gain, joined, solve_base, taken_over, wider
from pyident.diagnosis.search.search import Search
from pyident.regression.loads.bodies import carried_loads, link_columns, link_names, per_load
from pyident.regression.loads.tangent import degree_in_load
from pyident.regression.spectrum import Equations

_ROUNDS = 20  # until a coefficient rests
_RESTS = 0.05  # of its standard deviation
_CHANCE = 9.0  # of an energy: the square of three standard deviations
_STEP = 1e-4  # of a nonlinear value
_SURE = 3.0  # standard deviations
_MATTERS = 0.3  # of a law's force
_LOOSE = 2.0  # times: a coefficient that may be as much larger is not told


def gain_beside(search: Search, others: Sequence[Candidate], candidate: Candidate) -> Gain:
    """A candidate's gain and coefficients in the data, beside others and the model's own parameters.

    Where rounds do not come to rest, its coefficients are those at the loads of the search, and std is inf.
    """
    listed = [*others, candidate]
    first = last = _fitted(search, search.robot, listed)
    loaded = {c.joint for c in listed if _reads_load(search.robot, c)}
    if not loaded:
        return _of_last(first.gain, candidate, search.robot)
    motions = [log.part.motion for log in search.examination.logs]
    asked = [{k: link_columns(search.robot, motion, k).T for k in loaded} for motion in motions]
    for _ in range(_ROUNDS):
        before, last = last, _fitted(search, last.robot, listed, _About(last.gain.coefficients, asked))
        old, new = (_of_last(fit.gain, candidate, search.robot) for fit in (before, last))
        if np.all(np.abs(new.coefficients - old.coefficients) <= _RESTS * new.std):
            return new
    own = _of_last(first.gain, candidate, search.robot)
    return replace(own, std=np.full_like(own.std, np.inf))


def loosely_told(search: Search, others: Sequence[Candidate], candidate: Candidate) -> np.ndarray:
    """(K + nonlinear,) which coefficients hang on nonlinear values that the logs do not tell; and these.

    Values of the grid that take as much, within three standard deviations of the noise, give others: the
    viscous part of a coupling and its ratio, of which the logs tell the product. Or values beside these do.
    """
    if not candidate.nonlinear or candidate.speeds:
        return np.zeros(width(search.robot, candidate) + len(candidate.nonlinear), bool)
    view, ex = search.resting_on(others), search.examination
    grid = [ex.candidates[i] for i in search.families.members[candidate.family]]
    every = [view.gain_of(c) for c in (candidate, *grid)]
    as_good = np.array([g.coefficients for g in every if g.energy > every[0].energy - _CHANCE])
    low, high = np.abs(as_good).min(axis=0), np.abs(as_good).max(axis=0)
    loose = (np.ptp(np.sign(as_good), axis=0) > 1) | (high > _LOOSE * low)
    valley = _along_a_valley(view, candidate, every[0].coefficients, grid)
    valley[: len(loose)] |= loose
    return valley


def _along_a_valley(
    view: Search, candidate: Candidate, x: np.ndarray, grid: Sequence[Candidate]
) -> np.ndarray:
    """(K + nonlinear,) which of its coefficients x (K,) and nonlinear values are uncertain by their own size.

    All are taken together: a long spring that nearly cancels itself does what a short one does. One that is
    near zero counts if so much of it would make a good part of the law's force, or of the grid.
    """
    values, slopes = dict(candidate.values), []
    for name, value in candidate.values:
        step = _STEP * max(abs(value), _STEP)
        ends = (view.columns(candidate.at({**values, name: value + way * step})) for way in (1, -1))
        pairs = zip(*ends, strict=True)
        slopes.append(
            [{row: ((up[row] - down[row]) @ x / (2 * step))[:, None] for row in up} for up, down in pairs]
        )
    own, together = view.columns(candidate), joined([view.columns(candidate), *slopes])
    force = sum(float(np.square(X @ x).sum()) for log in own for X in log.values())
    sizes = np.sqrt(sum(np.square(X).sum(axis=0) for log in together for X in log.values()))
    least = _MATTERS * np.sqrt(force) / np.maximum(sizes, 1e-300)
    widths = [_MATTERS * np.ptp([dict(c.values)[name] for c in grid]) for name in values]
    least[len(x) :] = np.minimum(least[len(x) :], widths)
    return _SURE * gain(view.base, together).std > np.maximum(np.abs([*x, *values.values()]), least)


@dataclass(frozen=True)
class _About:
    """What a round is about. coefficients: of all laws;  asked: per log, joint -> (10 links, N)."""

    coefficients: np.ndarray
    asked: Sequence[Mapping[int, np.ndarray]]


@dataclass(frozen=True)
class _Fit:
    """gain: of all laws together;  robot: with the bodies found beside them."""

    gain: Gain
    robot: Robot


def _fitted(search: Search, robot: Robot, listed: Sequence[Candidate], about: _About | None = None) -> _Fit:
    """One round about a robot's bodies and the coefficients of all laws; none: with the loads as they are."""
    ex = search.examination
    levels = [level / ex.raised[:, None] for level in ex.levels]
    p = np.array(list(robot.linear_parameters.values()))
    logs = [e.over(1 / ex.raised[:, None]) for e in ex.logs]
    logs = [replace(e, y=e.y - e.A @ p) for e in logs]
    if about is not None:
        frictions = _frictions(robot, listed, about.coefficients)
        each = zip(logs, levels, about.asked, strict=True)
        logs = [_tangent(robot, frictions, *of_log) for of_log in each]
    bearing = [robot if _reads_load(robot, c) else search.robot for c in listed]
    X = joined([columns(at, c, ex.logs, levels) for at, c in zip(bearing, listed, strict=True)])
    raised = raised_floors(wider(logs, X), p, ex.raised)
    base = solve_base([e.over(raised[:, None]) for e in logs])
    X = [{row: part / raised[row] for row, part in rows.items()} for rows in X]
    found = gain(base, X, *bounds_of(robot, listed))
    p = p + base.p - taken_over(base, X) @ found.coefficients
    return _Fit(found, with_bodies(robot, p))


Frictions = Sequence[tuple[Candidate, np.ndarray]]  # laws of the load, and their coefficients


def _frictions(robot: Robot, listed: Sequence[Candidate], coefficients: np.ndarray) -> Frictions:
    ends = np.cumsum([width(robot, c) for c in listed])[:-1]
    each = zip(listed, np.split(coefficients, ends), strict=True)
    return [(c, x) for c, x in each if _reads_load(robot, c)]


def _tangent(
    robot: Robot, frictions: Frictions, log: Equations, level: np.ndarray, asked: Mapping[int, np.ndarray]
) -> Equations:
    """The equations with what bodies change in friction among the bodies' columns.

    level   (n, E);  asked: joint -> (10 links, N)
    """
    motion, names = log.part.motion, list(robot.linear_parameters)
    links = [names.index(name) for name in link_names(robot)]
    A = log.A.copy()
    for c, x in frictions:
        row = c.joint - 1
        per_unit = [by_row[row] for by_row in slopes(robot, c, motion).values()]
        growth = degree_in_load(law_of(robot, c)) * np.dot(x, per_unit)
        slope = per_load(growth, carried_loads(robot, motion)[:, row])
        A[row][:, links] += whitened(log, level[row], row, asked[c.joint] * slope)
    return replace(log, A=A)


def _reads_load(robot: Robot, candidate: Candidate) -> bool:
    """Whether it is a law of the load of a rigid joint, which bodies make."""
    rigid = not robot.joints[candidate.joint - 1].flexible
    return rigid and not candidate.describes and signals.load in law_of(robot, candidate).symbols


def _of_last(found: Gain, candidate: Candidate, robot: Robot) -> Gain:
    """A gain with the coefficients of its last candidate alone."""
    own = slice(-width(robot, candidate), None)
    return replace(found, coefficients=found.coefficients[own], std=found.std[own], alone=found.alone[own])
