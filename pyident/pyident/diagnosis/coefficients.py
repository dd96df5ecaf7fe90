"""Coefficients of what is named: fitted together, each equation weighed by what all of it leaves there.

The search weighs an equation by what the model without any law leaves, so that a strong law makes its own
equation light, and intervals from there are wide by as much as the law stands above the floor.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyident.diagnosis.base.balance import raised_floors
from pyident.diagnosis.base.candidates import Candidate, bounds
from pyident.diagnosis.base.projection import Columns, Gain, extended, gain, joined, solve_base
from pyident.diagnosis.search.search import Search
from pyident.regression.spectrum import Equations


def gain_beside(search: Search, others: Sequence[Candidate], candidate: Candidate) -> Gain:
    """A candidate's gain and coefficients in the data, beside others and the model's own parameters."""
    ex = search.examination
    every = [_times(search.columns(c), ex.raised) for c in (*others, candidate)]
    plain = [e.over(1 / ex.raised[:, None]) for e in ex.logs]
    raised = raised_floors(_wider(plain, joined(every)), ex.raised)
    base = solve_base([e.over(raised[:, None]) for e in plain])
    *beside, own = (_times(columns, 1 / raised) for columns in every)
    for columns in beside:
        base = extended(base, columns)
    return gain(base, own, *bounds(search.robot, candidate))


def _times(columns: Columns, factor: np.ndarray) -> Columns:
    """Each equation's columns times its factor (n,)."""
    return [{row: X * factor[row] for row, X in rows.items()} for rows in columns]


def _wider(logs: Sequence[Equations], columns: Columns) -> list[Equations]:
    """The equations with K more unknowns."""
    out = []
    for log, rows in zip(logs, columns, strict=True):
        K = next(iter(rows.values())).shape[1]
        dense = np.zeros((*log.y.shape, K))
        for row, X in rows.items():
            dense[row] = X
        out.append(replace(log, A=np.concatenate([log.A, dense], axis=2)))
    return out
