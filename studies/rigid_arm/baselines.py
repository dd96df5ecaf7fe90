"""What simpler methods would have named, on the same whitened columns of the same cases.

Every name comes with a strength, so that a method can be made more careful afterwards: it stops before the
first name that is weaker. A strength compares between the cases of one method only.
"""

from collections.abc import Callable

import numpy as np
from scipy.stats import f as fisher

from pyident.diagnosis.base.projection import Base, extended, gain
from pyident.diagnosis.search.search import Search

Name = tuple[str, int]
Strengths = dict[Name, float]  # in the order of their finding
_LEVEL = 0.01
_MOST = 6


def largest_drop(search: Search) -> Strengths:
    """The candidate that lowers the residual most, always; its share of it."""
    name, energy, _, _ = _best(search)
    return {name: energy / search.base.energy}


def stepwise(search: Search) -> Strengths:
    """Forward selection by F-tests, Bonferroni over all candidates; strong by the ratio of likelihoods."""
    count, listed = sum(r.size for r in search.base.residual), len(search.families.columns)

    def strength(base: Base, energy: float, K: int) -> float:
        left, freedom = base.energy - energy, count - base.basis[0].shape[2] - K
        chance = fisher.sf(energy / K / max(left / freedom, 1e-300), K, freedom) * listed
        return float(-count * np.log1p(-energy / base.energy)) if chance <= _LEVEL else 0.0

    return _forward(search, strength)


def bayesian_information(search: Search) -> Strengths:
    """Forward selection as long as n ln(energy) + K ln(n) falls; by how much it falls."""
    count = sum(r.size for r in search.base.residual)

    def strength(base: Base, energy: float, K: int) -> float:
        return float(-(count * np.log(1 - energy / base.energy) + K * np.log(count)))

    return _forward(search, strength)


def _forward(search: Search, strength: Callable[[Base, float, int], float]) -> Strengths:
    """One name after the other, as strong as the weakest so far, until one has none.

    strength   of what takes an energy of a base's residual with K parameters; 0 or less: none
    """
    names: Strengths = {}
    base, weakest = search.base, np.inf
    for _ in range(_MOST):
        name, energy, K, number = _best(search, base)
        weakest = min(weakest, strength(base, energy, K))
        if weakest <= 0:
            break
        names.setdefault(name, weakest)
        base = extended(base, search.families.columns[number])
    return names


def replicas_alone(search: Search) -> Strengths:
    """What takes most, if no replica shows as much (1 - p): the first gate of a diagnosis."""
    step = search.step()
    best = step.best.candidate
    return {(best.effect, best.joint): 1 - step.p_value} if step.p_value <= search.rules.level else {}


METHODS = {
    "largest drop": largest_drop,
    "stepwise F-test": stepwise,
    "forward BIC": bayesian_information,
    "replicas alone": replicas_alone,
}


def _best(search: Search, base=None):
    base = base or search.base
    families = search.families
    gains = [gain(base, X, *b) for X, b in zip(families.columns, families.bounds, strict=True)]
    number = int(np.argmax([g.energy for g in gains]))
    c = search.examination.candidates[number]
    return (c.effect, c.joint), gains[number].energy, len(gains[number].coefficients) + len(c.values), number
