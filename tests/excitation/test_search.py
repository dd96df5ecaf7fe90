"""The search climbs, keeps to its budget, and gives its best when it is stopped."""

import numpy as np

from pyident.excitation.search import Budget, best_of


def hill(x: np.ndarray) -> float:
    return -float(np.sum((x - 1.5) ** 2))


def test_it_climbs_a_hill_within_its_budget():
    found = best_of(hill, [np.zeros(5), np.ones(5)], Budget(evaluations=600, seconds=100))
    assert found.score > -1e-2
    assert found.evaluations <= 600
    assert not found.stopped


def test_an_interrupt_gives_the_best_so_far():
    seen = []

    def interrupted(x: np.ndarray) -> float:
        if len(seen) == 40:
            raise KeyboardInterrupt
        seen.append(hill(x))
        return seen[-1]

    found = best_of(interrupted, [np.zeros(4)], Budget(evaluations=500, seconds=100))
    assert found.stopped
    assert found.score == max(seen)


def test_motions_that_cannot_be_run_do_not_end_it():
    def half(x: np.ndarray) -> float:
        return -np.inf if x[0] < 0 else hill(x)

    found = best_of(half, [-np.ones(3), np.ones(3)], Budget(evaluations=300, seconds=100))
    assert np.isfinite(found.score)
