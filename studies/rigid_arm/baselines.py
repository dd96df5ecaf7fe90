"""What simpler methods would have named, on the same whitened columns of the same cases."""

import numpy as np
from scipy.stats import f as fisher

from pyident.diagnosis.base.projection import extended, gain
from pyident.diagnosis.search.search import Search

Name = tuple[str, int]
_LEVEL = 0.01
_MOST = 6


def largest_drop(search: Search) -> list[Name]:
    """The candidate that lowers the residual most, always."""
    return [_best(search)[0]]


def stepwise(search: Search) -> list[Name]:
    """Forward selection by F-tests, Bonferroni over all candidates."""
    names: list[Name] = []
    base, count = search.base, sum(r.size for r in search.base.residual)
    listed = len(search.families.columns)
    while len(names) < _MOST:
        name, energy, K, number = _best(search, base)
        left = base.energy - energy
        freedom = count - base.basis[0].shape[2] - K
        if fisher.sf(energy / K / max(left / freedom, 1e-300), K, freedom) * listed > _LEVEL:
            break
        names.append(name)
        base = extended(base, search.families.columns[number])
    return list(dict.fromkeys(names))


def bayesian_information(search: Search) -> list[Name]:
    """Forward selection as long as n ln(energy) + K ln(n) falls."""
    names: list[Name] = []
    base, count = search.base, sum(r.size for r in search.base.residual)
    while len(names) < _MOST:
        name, energy, K, number = _best(search, base)
        if count * np.log(1 - energy / base.energy) + K * np.log(count) >= 0:
            break
        names.append(name)
        base = extended(base, search.families.columns[number])
    return list(dict.fromkeys(names))


def replicas_alone(search: Search) -> list[Name]:
    """What takes most, if no replica shows as much: the first gate of a diagnosis, without the others."""
    step = search.step()
    best = step.best.candidate
    return [(best.effect, best.joint)] if step.p_value <= search.rules.level else []


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
