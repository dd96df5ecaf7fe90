"""What candidates, fitted to some logs, take away of the residual in others.

Their coefficients are those of the fitted logs. So are the model's own parameters, or these are found anew in
every held-out log, whichever tells more: friction that has warmed up, an offset, or bodies that the fitted
motion hardly shows may leave more there than what is missing, and hide it; and in a short log new parameters
may imitate what is missing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pyident.diagnosis.base.candidates import Candidate, bounds_of, columns, law_of
from pyident.diagnosis.base.projection import Base, extended, gain, joined, solve_base
from pyident.diagnosis.base.residual_over_floor import Region, bands_of, whitened, with_needed_torques
from pyident.diagnosis.search.search import Search
from pyident.logs.log import Log
from pyident.regression.spectrum import Equations
from pyident.rules.confidence import CONFIDENCE
from pyident.rules.search import SearchRules


@dataclass(frozen=True)
class Unseen:
    """Of what exceeds the floor on held-out logs: the share that is taken, its standard deviation; and that
    excess itself, in floors. Where hardly anything exceeds it, of the least that would count.

    With the residual r of the effects and s what they take, the energy falls by Σ (r + s)² − r², and the
    noise in r makes that vary by 4 Σ s² r². Parameters of the fitted logs, known as well as their noise lets
    them, shift r by a sum over these logs' equations, which varies likewise.

    kept   the fall over Σ s²: 1 where s is what was missing, whatever its size, and below 0 where s is wrong
    """

    share: float
    std: float
    excess: float
    kept: float

    @property
    def deviations(self) -> float:
        """Standard deviations from zero of the size that these logs by themselves give the effects."""
        return self.share * (1 + 1 / self.kept) / self.std if self.kept > 0 else 0.0

    @property
    def size(self) -> float:
        """What is missing there by these logs themselves, over what the effects take as fitted."""
        return (1 + self.kept) / 2

    def of_floor(self, rules: SearchRules) -> float:
        """What is taken, of the floor's energy."""
        return self.share * max(self.excess, rules.unseen_excess)

    def of_one_size(self, rules: SearchRules, std: float = 0.0) -> bool:
        """Whether what is missing there has about the size of what the effects take, or differs by chance.

        By chance or not, half of it or twice it is another size: which logs were fitted does not matter.

        std   of that size in the fitted logs, as a share of it
        """
        if not rules.unseen <= self.size <= 1 / rules.unseen:
            return False
        chance = np.hypot(self.size / max(self.deviations, 1e-300), std) if self.deviations else 0.0
        return abs(self.size - 1) <= max(rules.unseen / 2, rules.again * chance)

    def __str__(self) -> str:
        return f"{100 * self.share:.0f} ± {100 * self.std:.0f} %"


@dataclass(frozen=True)
class _Fitted:
    """Candidates, the model's parameters p (P,) and their coefficients x (K,), from the fitted logs."""

    candidates: Sequence[Candidate]
    p: np.ndarray
    x: np.ndarray


@dataclass(frozen=True)
class HeldOut:
    """Equations of logs that were not used, over the floor of those that were; may be none."""

    equations: tuple[Equations, ...]

    def share(self, search: Search, further: Sequence[Candidate], region: Region) -> Unseen | None:
        """What further candidates take beyond what the search rests on; None without held-out logs."""
        if not self.equations:
            return None
        before, after = (
            _Fitted(chosen, *search.fitted(chosen)) for chosen in (search.chosen, [*search.chosen, *further])
        )
        beside = search.with_further(further)
        found = [self._share(beside, before, after, region, carried) for carried in (True, False)]
        return max(found, key=lambda unseen: unseen.share - unseen.std)

    def beside(self, search: Search) -> Iterator[tuple[Equations, Base]]:
        """Each log with its own parameters, and coefficients of what the search rests on."""
        for log, base in zip(self.equations, self._bases, strict=True):
            level = [search.examination.floor.at(log.band)]
            for candidate in search.chosen:
                base = extended(base, columns(search.robot, candidate, [log], level))
            yield log, base

    def together(self, search: Search, candidate: Candidate) -> np.ndarray:
        """(K,) a candidate's coefficients beside what the search rests on, in the fitted logs and these.

        Of the fitted logs alone where each of them has a friction of its own.
        """
        ex = search.examination
        if ex.base.basis[0].shape[2] > ex.base.directions.shape[1]:
            return search.gain_of(candidate).coefficients
        logs = [*ex.logs, *self.equations]
        levels = [*search.levels, *(ex.floor.at(log.band) for log in self.equations)]
        listed = [*search.chosen, candidate]
        X = joined([columns(search.robot, c, logs, levels) for c in listed])
        found = gain(solve_base(logs), X, *bounds_of(search.robot, listed))
        return found.coefficients[-len(law_of(search.robot, candidate).linear) :]

    def left(self, search: Search, rows: Sequence[int]) -> float:
        """Energy beyond the floor that the search leaves on some equations of these logs; 0 without any."""
        if not self.equations:
            return 0.0
        bands = bands_of(self.equations)
        each = (self.residuals(search, anew) for anew in (False, True))
        return min(search.examination.excess(left, bands, rows)[0] for left in each)

    def residuals(self, search: Search, anew: bool) -> list[np.ndarray]:
        """Per log (n, E) what is left beside all that the search rests on.

        anew   with parameters of the model that each log has for itself, not those of the fitted logs
        """
        return self._residuals(search, _Fitted(search.chosen, *search.fitted(search.chosen)), anew)

    def _share(
        self, search: Search, before: _Fitted, after: _Fitted, region: Region, carried: bool
    ) -> Unseen:
        """carried: with the model's parameters of the fitted logs, not with those each log has for itself.

        search: with the effects.
        """
        bands = bands_of(self.equations)
        within = region.within(bands)
        left, rest = (self._residuals(search, fitted, not carried) for fitted in (before, after))
        pairs = [(b[i], a[i]) for b, a, i in zip(left, rest, within, strict=True)]
        fall = sum(float((np.square(b) - np.square(a)).sum()) for b, a in pairs)
        taken = sum(float(np.square(b - a).sum()) for b, a in pairs)
        variance = sum(float((np.square(b - a) * np.square(a)).sum()) for b, a in pairs)
        if carried:
            variance += self._of_parameters(search.base, [b - a for b, a in pairs], within)
        variance *= 4
        excess, floor = search.examination.excess(left, region.inside(bands), region.rows)
        scale = max(excess, search.rules.unseen_excess * floor, 1e-300)
        return Unseen(
            fall / scale,
            float(np.sqrt(variance)) / scale,
            excess / max(floor, 1e-300),
            fall / max(taken, 1e-300),
        )

    def _of_parameters(
        self, base: Base, taken: Sequence[np.ndarray], within: Sequence[tuple[np.ndarray, ...]]
    ) -> float:
        """Variance of Σ s r by the noise in the parameters of the fitted logs; s: `taken` within each log."""
        every = zip(self.equations, taken, within, strict=True)
        slope = sum(np.einsum("cep,ce->p", log.A[i], s) for log, s, i in every)
        along = base.directions.T @ np.asarray(slope)
        weights = [basis[:, :, : len(along)] @ along for basis in base.basis]
        pairs = zip(weights, base.residual, strict=True)
        return sum(float((np.square(w) * np.square(r)).sum()) for w, r in pairs)

    @cached_property
    def _bases(self) -> list[Base]:
        """Of each log alone."""
        return [solve_base([log]) for log in self.equations]

    def _residuals(self, search: Search, fitted: _Fitted, anew: bool) -> list[np.ndarray]:
        """Per log (n, E)."""
        pairs = zip(self.equations, self._bases, strict=True)
        x, acting = fitted.x, fitted.candidates
        return [_left_of(search, log, base if anew else fitted.p, x, acting) for log, base in pairs]

    def holds(self, unseen: Unseen, fitted_share: float, rules: SearchRules) -> bool:
        """Whether the share on unseen data stands beside the one on those that were fitted.

        Where these hold hardly anything to explain, what the effects take must be there, and not by chance.
        """
        if unseen.excess < rules.unseen_excess:
            return unseen.kept >= rules.unseen and unseen.deviations >= rules.chance
        return unseen.share >= rules.unseen * fitted_share and unseen.share > CONFIDENCE * unseen.std


def held_out(search: Search, logs: Sequence[Log]) -> HeldOut:
    """Raises LogError."""
    ex = search.examination
    moved = ex.setting.alignment.of_all(ex.setting.robot, logs)
    found = whitened(ex.setting.robot, moved, [ex.floor] * len(moved))
    return HeldOut(tuple(found if ex.setting.simulates else with_needed_torques(ex.setting.simulated, found)))


def _left_of(
    search: Search, log: Equations, own: Base | np.ndarray, x: np.ndarray, acting: Sequence[Candidate]
) -> np.ndarray:
    """Of one log under its own base, or parameters (P,); a payload is there or not, whichever fits."""
    residual = own.residual[0] if isinstance(own, Base) else log.y - log.A @ own
    at = 0
    for candidate in acting:
        everywhere = replace(candidate, log=None)
        X = columns(search.robot, everywhere, [log], [search.examination.floor.at(log.band)])[0]
        width = next(iter(X.values())).shape[1]
        force = np.zeros_like(residual)
        for c, values in X.items():
            force[c] = values @ x[at : at + width]
        more = residual - (_beyond(own, force) if isinstance(own, Base) else force)
        if candidate.log is None or np.square(more).sum() < np.square(residual).sum():
            residual = more
        at += width
    return residual


def _beyond(base: Base, force: np.ndarray) -> np.ndarray:
    """What a base cannot imitate of one log's (n, E)."""
    return force - base.basis[0] @ np.tensordot(force, base.basis[0], 2)
