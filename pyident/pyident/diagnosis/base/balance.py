"""Weights of the equations of a model that lacks something in some of them.

What is missing in one equation bends the parameters that it shares with others, so that all of them leave
more than their floors. The floor of each is therefore multiplied by a factor, at least one, which is found
with the parameters as the most likely one where the residual of every equation is normal with a variance of
its own: fit and variances in turn, each of which raises the likelihood. It has several maxima, since a misfit
may be moved from one equation to its neighbours. So the search sets out from no suspicion, then from each
equation as the one that is wrong, then from two of them, as long as the best becomes more likely.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyident.diagnosis.base.projection import solution_of, triangles
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


def raised_floors(data: Sequence[Equations], start: np.ndarray | None = None) -> np.ndarray:
    """(n,) the factor of each equation's floor.

    start   factors (n,) from which alone to set out; none: from every suspicion
    """
    rows, count = triangles(data), sum(e.y.shape[1] for e in data)
    best = _maximum(rows, count, np.ones(len(rows)) if start is None else start)
    suspected: list[int] = []
    while start is None and len(suspected) < len(rows) - 1:
        others = [i for i in range(len(rows)) if i not in suspected]
        trials = {i: _maximum(rows, count, _suspecting(len(rows), [*suspected, i])) for i in others}
        worst = min(trials, key=lambda i: trials[i].unlikely)
        if trials[worst].unlikely > best.unlikely - _BETTER:
            break
        best, suspected = trials[worst], [*suspected, worst]
    return best.raised


def _suspecting(count: int, rows: Sequence[int]) -> np.ndarray:
    """Factors with which some equations count for nothing, and all others fully."""
    raised = np.ones(count)
    raised[list(rows)] = _SUSPECTED
    return raised


def _maximum(rows: Sequence[np.ndarray], count: int, raised: np.ndarray) -> _Maximum:
    """The maximum above some factors. rows: triangles of equations;  count: of each one's samples."""
    for _ in range(_ROUNDS):
        left = _left(rows, raised) / np.sqrt(count)
        new = np.maximum(left, 1.0)
        rests = np.all(np.abs(np.log(new / raised)) < _RESTS)
        raised = new
        if rests:
            break
    return _Maximum(raised, _unlikely(_left(rows, raised) / np.sqrt(count)))


def _unlikely(left: np.ndarray) -> float:
    """left (n,): what each equation leaves of its own floor.

    One that leaves more has got a variance of its own. One that leaves less is as unlikely as its energy is
    by its floor's noise, a chi square: equations without a torque are fitted best by no parameters at all.
    """
    below = np.maximum(np.minimum(left, 1.0), 1e-300)
    return float(np.sum(np.log(np.maximum(left, 1.0)) - np.log(below) + (np.square(below) - 1) / 2))


def _left(rows: Sequence[np.ndarray], raised: np.ndarray) -> np.ndarray:
    """(n,) norm of what each equation leaves at its own floor."""
    p, _ = solution_of([R / factor for R, factor in zip(rows, raised, strict=True)])
    return np.array([np.linalg.norm(R[:, :-1] @ p - R[:, -1]) for R in rows])
