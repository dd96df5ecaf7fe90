"""Nonlinear values of a law between those of its grid, by variable projection.

At each value the linear parameters are eliminated (Golub and Pereyra 1973); Nelder and Mead move the rest.
And whether the values make the law what its name says.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize

from flexmodels.coordinate import of_joint
from flexmodels.effects import signals
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of

BEYOND = 1.5  # times the grid's ends: so far a value is looked for
_TRIALS = 60
_SIMPLICES = (0.2, -0.05)  # of the range: first edges of the simplex
_PER_TURN = 1.0  # between a periodic law's order and its neighbours: the next period is another law
_PRECISION = 0.01  # of the range between neighbours
_AT_LOWEST = 1.02  # times the lowest order
_SURER = 1.0  # variance of noise: what explains no more is less than a standard deviation away


def refined(
    robot: Robot, start: Candidate, listed: Sequence[Candidate], explained: Callable[[Candidate], float]
) -> Candidate:
    """The candidate that explains most between the neighbours of `start` on the grid `listed`.

    Where noise hardly tells it from the start, the start: a value that the logs do not tell is anywhere, and
    makes coefficients that other logs refuse. Two motors of an arm that turn alike have any ratio.
    """
    if not start.nonlinear:
        return start
    names, middle, low, high = _range(robot, start, listed)

    def candidate(x: np.ndarray) -> Candidate:
        return start.at(dict(zip(names, (middle + x * (high - low)).tolist(), strict=True)))

    def missed(x: np.ndarray) -> float:
        return -explained(candidate(x))

    ranges = list(zip((low - middle) / (high - low), (high - middle) / (high - low), strict=True))
    best = np.zeros(len(names))
    begun = least = -explained(start)
    for size in _SIMPLICES:  # again from where the first ended, the other way round: a simplex may collapse
        steps = np.clip(best + size * np.eye(len(names)), *np.array(ranges).T)
        options = {
            "maxfev": _TRIALS,
            "initial_simplex": np.vstack([best, steps]),
            "xatol": _PRECISION,
            "fatol": 1e-4 * abs(least),
        }
        found: Any = minimize(missed, best, method="Nelder-Mead", bounds=ranges, options=options)
        if found.fun >= least:
            break
        best, least = np.asarray(found.x), float(found.fun)
    return candidate(best) if least < begun - _SURER else start


def of_whole_periods(
    robot: Robot, listed: Sequence[Candidate], energies: Sequence[float]
) -> list[tuple[Candidate, int]]:
    """Of a family's candidates, with their numbers, the strongest first, those that a period may be seen of.

    energies   (C) what each explains. Of a periodic torque the lowest order is no candidate, nor is what lies
    on its flank, as far as the energy only falls: a slow torque hides no ripple that way.
    """
    at, order = list(range(len(listed))), law_of(robot, listed[0]).order_of_torque
    if order is not None and not listed[0].speeds:
        at.sort(key=lambda i: dict(listed[i].values)[order.name])
        rises = (n for n in range(1, len(at)) if energies[at[n]] >= energies[at[n - 1]])
        at = at[next(rises, len(at)) :]
    return [(listed[i], i) for i in sorted(at, key=lambda i: -energies[i])]


def wants_no_period(robot: Robot, candidate: Candidate, listed: Sequence[Candidate]) -> bool:
    """Whether a periodic torque's best order is the lowest: less than a period fits better, like a spring."""
    order = law_of(robot, candidate).order_of_torque
    if order is None or candidate.speeds:
        return False
    orders = [dict(c.values)[order.name] for c in listed if c.family == candidate.family]
    return dict(candidate.values)[order.name] <= _AT_LOWEST * min(orders)


def proper(
    robot: Robot,
    candidate: Candidate,
    coefficients: Sequence[float],
    parameters: Mapping[str, float],
    period: float,
) -> bool:
    """Whether the values found make the effect what its name says, beside the robot's own parameters.

    period   [s] of the logs
    """
    law = law_of(robot, candidate)
    if law.proper is None:
        return True
    own = dict(candidate.values) | dict(zip((p.name for p in law.linear), coefficients, strict=True))
    own[signals.period.name] = period
    known = {
        symbol: own.get(symbol.name, parameters.get(of_joint(candidate.joint, f"{symbol.name}")))
        for symbol in law.proper.free_symbols
    }
    return bool(law.proper.subs(known))


def _range(
    robot: Robot, candidate: Candidate, listed: Sequence[Candidate]
) -> tuple[list[str], np.ndarray, np.ndarray, np.ndarray]:
    """Names, values, lower and upper ends of the nonlinear parameters: the ends are the grid's neighbours."""
    grid = np.array([[v for _, v in c.values] for c in listed if c.family == candidate.family])
    start, low, high = [], [], []
    law = law_of(robot, candidate)
    for j, parameter in enumerate(law.nonlinear):
        value = candidate.values[j][1]
        others = np.unique(np.append(grid[:, j], value))
        at = int(np.searchsorted(others, value))
        reach = max(float(np.diff(others).max()), 1e-3 * abs(value)) if len(others) > 1 else abs(value) / 2
        below = others[at - 1] if at > 0 else (value / BEYOND if value > 0 else value - reach)
        above = others[at + 1] if at + 1 < len(others) else (BEYOND * value if value > 0 else value + reach)
        if parameter.periodic:
            below, above = max(below, value - _PER_TURN), min(above, value + _PER_TURN)
        if parameter is law.order_of_torque and not candidate.speeds:
            below = max(below, others[0])  # the lowest shows a whole period
        start.append(value)
        low.append(max(below, parameter.lower))
        high.append(min(above, parameter.upper))
    return [name for name, _ in candidate.values], np.array(start), np.array(low), np.array(high)
