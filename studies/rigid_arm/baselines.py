"""What simpler methods would have named, on the same whitened columns of the same cases.

Every name comes with a strength, so that a method can be made more careful afterwards: it stops before the
first name that is weaker. A strength compares between the cases of one method only.
"""

import numpy as np
from scipy.stats import f as fisher

from pyident.diagnosis.base.projection import extended, gain
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
    names: Strengths = {}
    base, count = search.base, sum(r.size for r in search.base.residual)
    listed = len(search.families.columns)
    strength = np.inf
    for _ in range(_MOST):
        name, energy, K, number = _best(search, base)
        left = base.energy - energy
        freedom = count - base.basis[0].shape[2] - K
        if fisher.sf(energy / K / max(left / freedom, 1e-300), K, freedom) * listed > _LEVEL:
            break
        strength = min(strength, float(-count * np.log1p(-energy / base.energy)))
        names.setdefault(name, strength)
        base = extended(base, search.families.columns[number])
    return names


def bayesian_information(search: Search) -> Strengths:
    """Forward selection as long as n ln(energy) + K ln(n) falls; by how much it falls."""
    names: Strengths = {}
    base, count = search.base, sum(r.size for r in search.base.residual)
    strength = np.inf
    for _ in range(_MOST):
        name, energy, K, number = _best(search, base)
        change = count * np.log(1 - energy / base.energy) + K * np.log(count)
        if change >= 0:
            break
        strength = min(strength, float(-change))
        names.setdefault(name, strength)
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
