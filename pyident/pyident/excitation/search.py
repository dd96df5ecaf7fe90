"""The best of many vectors of numbers, by evolution (CMA-ES); it can be stopped and keeps its best."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Budget:
    """What a search may cost: evaluations, and seconds after which it ends with its best so far."""

    evaluations: int = 2000
    seconds: float = 120.0
    seed: int = 0


@dataclass(frozen=True)
class Best:
    """x (size,) with its score; the evaluations it took; stopped: somebody interrupted it."""

    x: np.ndarray
    score: float
    evaluations: int
    stopped: bool


def best_of(
    score: Callable[[np.ndarray], float],
    starts: Sequence[np.ndarray],
    budget: Budget,
    progress: Progress | None = None,
    step: float = 0.5,
) -> Best:
    """Maximise score over vectors, from the best of several starts (size,) each.

    step   first standard deviation of the search about it

    A KeyboardInterrupt, once a start has been judged, ends the search with the best so far.
    Source: Hansen, The CMA evolution strategy: a tutorial, arXiv:1604.00772.
    """
    best = Best(starts[0], score(starts[0]), 1, False)
    try:
        best = _searched(score, starts, budget, progress or (lambda _: None), best, step)
    except _Interrupted as stopped:
        best = stopped.best
    return best


class _Interrupted(Exception):
    def __init__(self, best: Best):
        super().__init__("stopped")
        self.best = best


def _searched(
    score: Callable[[np.ndarray], float],
    starts: Sequence[np.ndarray],
    budget: Budget,
    progress: Progress,
    best: Best,
    step: float,
) -> Best:
    from cma import CMAEvolutionStrategy

    begin = time.monotonic()

    def judged(x: np.ndarray) -> float:
        nonlocal best
        value = score(x)
        count = best.evaluations + 1
        best = Best(x, value, count, False) if value > best.score else Best(best.x, best.score, count, False)
        spent = max(count / budget.evaluations, (time.monotonic() - begin) / budget.seconds)
        progress(min(spent, 1.0))
        return value

    try:
        for x in starts[1:]:
            judged(x)
        options = {"seed": budget.seed + 1, "verbose": -9, "maxfevals": np.inf}
        evolution: Any = CMAEvolutionStrategy(best.x, step, options)
        while not evolution.stop():
            asked = evolution.ask()
            values = []
            for x in asked:
                if best.evaluations >= budget.evaluations or time.monotonic() - begin > budget.seconds:
                    return best
                values.append(-judged(x))
            evolution.tell(asked, values)
    except KeyboardInterrupt:
        raise _Interrupted(Best(best.x, best.score, best.evaluations, True)) from None
    return best
