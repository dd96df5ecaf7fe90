"""Which parameters the data determine alone, which only in combinations, and these combinations."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from scipy.linalg import qr, solve_triangular

from pyident.estimation.least_squares import ROUNDING, Solution
from pyident.regression.reduced import Reduced
from pyident.rules.confidence import CONFIDENCE

_Pivoted = tuple[np.ndarray, np.ndarray, np.ndarray]
Support = Literal["alone", "combination", "no"]
_WEAK = 1e-2  # of the largest singular value: below, a direction is said to be weakly determined
_ABSENT = 1e-3  # share of a scaled direction that is left out of an expression, unless it is seen:
_SEEN = 0.1  # standard deviations that a term may be worth without standing in the expression
_FEW = 3  # values that are named, of those that logs hardly tell
_NOTHING = 1e-7  # share of a scaled direction that is rounding, not the robot's structure


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


def hardly_told(base: Sequence[BaseParameter]) -> tuple[str, ...]:
    """A sentence about values that are no larger than noise may make them, where no interval says so.

    base   with the deviations of a regression, which are too small where what it rests on is doubted
    """
    loose = sorted((b for b in base if abs(b.value) < CONFIDENCE * b.std), key=lambda b: -b.std)
    if not loose:
        return ()
    named = "; ".join(f"{b.expression} = {b.value:.3g}" for b in loose[:_FEW])
    return (
        f"{len(loose)} of {len(base)} values are no larger than noise may make them, as {named}: joints that "
        "move together, and fast, would tell them",
    )


def supports(reduced: Reduced, solution: Solution) -> dict[str, Support]:
    """How each parameter is determined by the data."""
    never = (reduced.triangles[:, :, :-1] == 0).all(axis=(0, 1))
    return {
        name: "no" if never[i] else "combination" if solution.open[i] else "alone"
        for i, name in enumerate(reduced.columns)
    }


def base_parameters(reduced: Reduced, solution: Solution) -> list[BaseParameter]:
    """A set of `rank` independent combinations with values and standard deviations.

    Pivoted QR of the directions that the data see picks the leading parameters; every other parameter
    joins the combinations that it cannot be told apart from.
    """
    r, scale = solution.rank, solution.scale
    largest = np.abs(scale * solution.p).max(initial=0.0)
    strength = solution.singular_values[:r, None] * solution.seen.T
    _, R, order = cast(_Pivoted, qr(strength, mode="economic", pivoting=True))
    mixing = solve_triangular(R[:r, :r], R[:r, r:])
    lead, rest = order[:r], order[r:]
    out = []
    for i in np.argsort(lead):
        factors = np.zeros(len(scale))
        factors[lead[i]] = 1.0
        factors[rest] = mixing[i] * scale[rest] / scale[lead[i]]
        at = np.flatnonzero(factors)  # a parameter without an interval takes it from its own combination only
        std = np.sqrt(max(factors[at] @ solution.covariance[np.ix_(at, at)] @ factors[at], 0.0))
        seen = _SEEN * std * scale[lead[i]] / largest if largest and np.isfinite(std) else _ABSENT
        least = min(_ABSENT, max(_NOTHING, seen))
        kept = [lead[i], *(j for j, m in zip(rest, mixing[i], strict=True) if abs(m) > least)]
        terms = tuple((float(factors[j]), reduced.columns[j]) for j in kept)
        out.append(BaseParameter(terms, float(factors @ solution.p), float(std)))
    return out


def weakest_directions(reduced: Reduced, solution: Solution, count: int = 5) -> list[str]:
    """The directions that these data see badly, each as a sentence, worst first.

    Directions that no data can see (parameters that never appear but in combinations) are not among them;
    `base_parameters` writes these combinations out.
    """
    s = solution.singular_values / solution.singular_values[0]
    directions = np.hstack([solution.seen, solution.null])
    sentences = []
    for i in np.flatnonzero((s > ROUNDING) & (s < _WEAK))[::-1][:count]:
        size = np.abs(directions[:, i])
        names = [reduced.columns[j] for j in np.argsort(-size) if size[j] > 0.2 * size.max()][:6]
        joined = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
        verb = "acts alone" if len(names) == 1 else "act together"
        fate = "weakly determined" if i < solution.rank else "not determined"
        sentences.append(f"{joined} {verb}: {fate} (singular value {s[i]:.1e} of the largest)")
    return sentences
