"""Which parameters the data determine alone, which only in combinations, and these combinations."""

from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from scipy.linalg import qr, solve_triangular

from pyident.solve import Reduced, Solution

_Pivoted = tuple[np.ndarray, np.ndarray, np.ndarray]
Support = Literal["alone", "combination", "no"]
_ABSENT = 1e-3  # size of an entry of a scaled null direction that is taken as zero


@dataclass(frozen=True)
class BaseParameter:
    """A combination that the data determine: sum of factor * parameter."""

    terms: tuple[tuple[float, str], ...]
    value: float
    std: float

    @property
    def expression(self) -> str:
        first, *rest = self.terms
        text = first[1] if first[0] == 1 else f"{first[0]:.4g} {first[1]}"
        return text + "".join(f" {'+' if f > 0 else '-'} {abs(f):.4g} {name}" for f, name in rest)


def supports(reduced: Reduced, solution: Solution) -> dict[str, Support]:
    """How each parameter is determined by the data."""
    hidden = np.linalg.norm(solution.null, axis=1)
    never = np.linalg.norm(reduced.A, axis=0) == 0
    return {
        name: "no" if never[i] else "combination" if hidden[i] > _ABSENT else "alone"
        for i, name in enumerate(reduced.columns)
    }


def base_parameters(reduced: Reduced, solution: Solution) -> list[BaseParameter]:
    """A set of `rank` independent combinations with values and standard deviations.

    Pivoted QR of the directions that the data see picks the leading parameters; every other parameter
    joins the combinations that it cannot be told apart from.
    """
    r = solution.rank
    _, s, Vt = np.linalg.svd(reduced.A / solution.scale, full_matrices=False)
    seen = s[:r, None] * Vt[:r]
    _, R, order = cast(_Pivoted, qr(seen, mode="economic", pivoting=True))
    mixing = solve_triangular(R[:r, :r], R[:r, r:])
    lead, rest = order[:r], order[r:]
    squares = (solution.residual**2).sum() * reduced.samples
    sigma = np.sqrt(squares / max(reduced.samples * len(reduced.rows) - r, 1))
    spread = sigma * np.linalg.norm(np.linalg.inv(R[:r, :r]), axis=1) / solution.scale[lead]
    out = []
    for i in np.argsort(lead):
        factors = mixing[i] * solution.scale[rest] / solution.scale[lead[i]]
        kept = [j for j in range(len(rest)) if abs(mixing[i, j]) > _ABSENT]
        terms = (
            (1.0, reduced.columns[lead[i]]),
            *((float(factors[j]), reduced.columns[rest[j]]) for j in kept),
        )
        value = sum(f * solution.p[reduced.columns.index(name)] for f, name in terms)
        out.append(BaseParameter(terms, float(value), float(spread[i])))
    return out
