"""Weights of the equations of a model that lacks something in some of them.

What is missing in one equation bends the parameters that it shares with others, so that all of them leave
more than their floors. The floor of each is therefore multiplied by a factor, at least one, which is found
with the parameters as the most likely one where the residual of every equation is normal with a variance of
its own: fit and variances in turn, each of which raises the likelihood. It has several maxima, since a misfit
may be moved from one equation to its neighbours. So the search sets out from no suspicion, then from each
equation as the one that is wrong, then from two of them, as long as the best becomes more likely.

Equations without a torque are solved by no parameters at all, and the moment of a deformation's noise is as
small as the stiffness: what they leave counts by the size that their terms had where the floors are from.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, columns
from pyident.diagnosis.base.projection import joined, solution_of, triangles, wider
from pyident.regression.spectrum import Equations

_RESTS = 0.01  # change of a factor below which it rests
_ROUNDS = 50  # at most
_SUSPECTED = 1e4  # factor of an equation that counts for nothing
_BETTER = 0.01  # by which another maximum is less unlikely


@dataclass(frozen=True)
class _Maximum:
    """raised (n,) factors of floors;  unlikely: as `_unlikely` has it."""

    raised: np.ndarray
    unlikely: float


@dataclass(frozen=True)
class _Rows:
    """Triangles [A, y] of the equations.

    squares   (n, P) of their columns' lengths
    terms     (n,) of those without a torque, where the floors are from; 0 of the others
    """

    triangles: list[np.ndarray]
    squares: np.ndarray
    terms: np.ndarray

    @staticmethod
    def of(triangles: list[np.ndarray], p: np.ndarray) -> "_Rows":
        squares = np.array([np.square(R[:, :-1]).sum(axis=0) for R in triangles])
        free = np.array([not R[:, -1].any() for R in triangles])
        wide = np.concatenate([p, np.zeros(squares.shape[1] - len(p))])  # laws came after the floors
        return _Rows(triangles, squares, np.where(free, np.sqrt(squares @ wide**2), 0.0))

    def left(self, raised: np.ndarray) -> np.ndarray:
        """(n,) norm of what each equation leaves at its own floor, as large as its terms were."""
        p, _ = solution_of([R / factor for R, factor in zip(self.triangles, raised, strict=True)])
        norms = np.array([np.linalg.norm(R[:, :-1] @ p - R[:, -1]) for R in self.triangles])
        now = np.sqrt(self.squares @ p**2)
        return norms * np.maximum(self.terms / np.maximum(now, 1e-300), 1.0)


def raised_floors(
    data: Sequence[Equations], of_floors: np.ndarray, start: np.ndarray | None = None
) -> np.ndarray:
    """(n,) the factor of each equation's floor.

    of_floors   (P,) parameters with which the floors were made
    start       factors (n,) from which alone to set out; none: from every suspicion
    """
    rows, count = _Rows.of(triangles(data), of_floors), sum(e.y.shape[1] for e in data)
    best = _maximum(rows, count, np.ones(len(rows.triangles)) if start is None else start)
    suspected: list[int] = []
    number = len(rows.triangles)
    while start is None and len(suspected) < number - 1:
        others = [i for i in range(number) if i not in suspected]
        trials = {i: _maximum(rows, count, _suspecting(number, [*suspected, i])) for i in others}
        worst = min(trials, key=lambda i: trials[i].unlikely)
        if trials[worst].unlikely > best.unlikely - _BETTER:
            break
        best, suspected = trials[worst], [*suspected, worst]
    return best.raised


def raised_beside(
    robot: Robot, data: Sequence[Equations], levels: Sequence[np.ndarray], named: Sequence[Candidate]
) -> np.ndarray:
    """The same of a fitted robot's logs over their floors, beside laws and errors that are named.

    levels   per log (n, E), the floors
    """
    p = np.array(list(robot.linear_parameters.values()))
    if not named:
        return raised_floors(data, p)
    return raised_floors(wider(data, joined([columns(robot, c, data, levels) for c in named])), p)


def _suspecting(count: int, rows: Sequence[int]) -> np.ndarray:
    """Factors with which some equations count for nothing, and all others fully."""
    raised = np.ones(count)
    raised[list(rows)] = _SUSPECTED
    return raised


def _maximum(rows: _Rows, count: int, raised: np.ndarray) -> _Maximum:
    """The maximum above some factors. count: of each equation's samples."""
    for _ in range(_ROUNDS):
        left = rows.left(raised) / np.sqrt(count)
        new = np.maximum(left, 1.0)
        rests = np.all(np.abs(np.log(new / raised)) < _RESTS)
        raised = new
        if rests:
            break
    return _Maximum(raised, _unlikely(rows.left(raised) / np.sqrt(count)))


def _unlikely(left: np.ndarray) -> float:
    """left (n,): what each equation leaves of its own floor.

    One that leaves more has got a variance of its own. One that leaves less is as unlikely as its energy is
    by its floor's noise, a chi square: equations without a torque are fitted best by no parameters at all.
    """
    below = np.maximum(np.minimum(left, 1.0), 1e-300)
    return float(np.sum(np.log(np.maximum(left, 1.0)) - np.log(below) + (np.square(below) - 1) / 2))
