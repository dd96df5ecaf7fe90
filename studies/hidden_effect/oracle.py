"""What a diagnosis could have reached at best: the same refit, told the true effects."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyident.diagnosis.base.candidates import bounds
from pyident.diagnosis.base.projection import Base, Columns, gain
from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.next_steps import candidate_of
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.search.found import Found
from pyident.diagnosis.search.gate import region_of
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search

Name = tuple[str, int]  # an effect and its joint, from 1
ALIKE = 0.99  # of a force's energy: what imitates it this far is the same in these logs


@dataclass(frozen=True)
class Bound:
    """reached, achievable: share of what exceeds the floor on held-out data, on the equations of the true
              effects, that what was found and the truth take, %

    aliases   per true effect the other effects that would do exactly the same in these logs
    """

    reached_percent: float
    achievable_percent: float
    aliases: tuple[tuple[Name, ...], ...]


def bound(search: Search, diagnosis: Diagnosis, truth: Sequence[Name], held: HeldOut) -> Bound | None:
    """None where the catalogue does not have the truth at its joint, or nothing was held out."""
    best = _at_best(search, truth)
    if best is None:
        return None
    found = [candidate_of(search, finding.tie[0]) for finding in diagnosis.findings]
    search = search.resting_on(())
    true = [f.candidate for f in best]
    rows = {row for candidate in true for row in region_of(search, candidate).rows}
    reached, achievable = (
        held.share(search, listed, Region(tuple(sorted(rows)))) for listed in (found, true)
    )
    if reached is None or achievable is None:
        return None
    return Bound(
        100 * reached.share,
        100 * achievable.share,
        tuple(_aliases(search, best, i) for i in range(len(best))),
    )


def _at_best(search: Search, truth: Sequence[Name]) -> list[Found] | None:
    """Each true effect with its nonlinear parameters fitted, the others in the base; twice if several."""
    best: list[Found] = []
    for _ in range(min(len(truth), 2)):
        for i, (effect, joint) in enumerate(truth):
            others = [f.candidate for j, f in enumerate(best) if j != i]
            found = search.resting_on(others).best(effect, joint)
            if found is None:
                return None
            best[i : i + 1] = [found]
    return best


def _aliases(search: Search, best: Sequence[Found], number: int) -> tuple[Name, ...]:
    """Effects that imitate the force of one true effect, the other true ones in the base."""
    search = search.resting_on([f.candidate for j, f in enumerate(best) if j != number])
    own, coefficients = best[number].candidate, best[number].gain.coefficients
    force = _beyond(search.base, search.columns(own), coefficients)
    base = replace(search.base, residual=force)
    shares: dict[Name, float] = {}
    for c in search.examination.candidates:
        if c.family != own.family:
            share = gain(base, search.columns(c), *bounds(search.robot, c)).energy / max(base.energy, 1e-300)
            shares[c.family[:2]] = max(share, shares.get(c.family[:2], 0.0))
    return tuple(name for name, share in shares.items() if share >= ALIKE and name != own.family[:2])


def _beyond(base: Base, columns: Columns, coefficients: np.ndarray) -> list[np.ndarray]:
    """Per log (n, E): the force of some columns, without what the base imitates."""
    force = [np.zeros_like(r) for r in base.residual]
    for dense, rows in zip(force, columns, strict=True):
        for row, X in rows.items():
            dense[row] = X @ coefficients
    along = sum(np.einsum("cek,ce->k", b, f) for b, f in zip(base.basis, force, strict=True))
    return [f - b @ along for b, f in zip(base.basis, force, strict=True)]
