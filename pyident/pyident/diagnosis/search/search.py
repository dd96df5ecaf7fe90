"""Which of the candidates explain the residual, beyond what replicas pretend."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, bounds, bounds_of, columns, law_of, width
from pyident.diagnosis.base.nonlinear_values import of_whole_periods, proper, refined, wants_no_period
from pyident.diagnosis.base.projection import Base, Columns, Gain, extended, gain, gains
from pyident.diagnosis.base.residual_over_floor import Examination, Region
from pyident.diagnosis.base.setting import Setting
from pyident.diagnosis.base.shaken import with_shaken
from pyident.diagnosis.base.standing_out import over_floor, standing_out
from pyident.diagnosis.search.families import Families, families_of
from pyident.diagnosis.search.found import Found, Step
from pyident.diagnosis.search.power import knows_sign, of_wrong_sign
from pyident.rules.search import SearchRules


@dataclass(frozen=True, eq=False)
class Search:
    """The candidates of an examination against its base with those `chosen` joined to it."""

    examination: Examination
    families: Families
    base: Base
    chosen: tuple[Candidate, ...] = ()

    @property
    def robot(self) -> Robot:
        return self.examination.setting.robot

    @property
    def rules(self) -> SearchRules:
        return self.examination.setting.rules.search

    @property
    def levels(self) -> list[np.ndarray]:
        return self.examination.levels

    def resting_on(self, chosen: Sequence[Candidate]) -> "Search":
        """The search whose base is the examination's with these candidates, and no others, joined to it."""
        return replace(self, base=self._joined(self.examination.base, chosen), chosen=tuple(chosen))

    def about(self, setting: Setting) -> "Search":
        """The same search with columns of another fit of the robot; what it rests on is gone."""
        return replace(self, examination=replace(self.examination, setting=setting)).resting_on(())

    def with_further(self, candidates: Sequence[Candidate]) -> "Search":
        """The search that rests on further candidates as well."""
        return replace(self, base=self._joined(self.base, candidates), chosen=(*self.chosen, *candidates))

    def _joined(self, base: Base, candidates: Sequence[Candidate]) -> Base:
        """A base with candidates, and what waves among them do to other joints, joined to it."""
        for candidate in candidates:
            own = extended(base, self.columns(candidate))
            base = with_shaken(self.examination, candidate, own)
        return base

    def without(self, candidate: Candidate) -> "Search":
        """The search that rests on all but one of those that this one rests on."""
        return self.resting_on([c for c in self.chosen if c != candidate])

    def fitted(self, chosen: Sequence[Candidate]) -> tuple[np.ndarray, np.ndarray]:
        """The model's parameters (P,) and the candidates' coefficients, all fitted together."""
        if not chosen:
            return self.examination.base.p, np.zeros(0)
        return self.families.joint.of(
            chosen, [self.columns(c) for c in chosen], bounds_of(self.robot, chosen)
        )

    def step(self, rows: Sequence[int] | None = None) -> Step:
        """Rank the families by what they explain of the present base's residual.

        rows   equations that are asked about, none: all; what acts on no such keeps the values of the grid
        """
        each = gains(self.base, self.families.columns, self.families.bounds)
        found = []
        for number, at in enumerate(self.families.members.values()):
            candidate, explained = self._best_proper(at, [each[i] for i in at])
            found.append(self._found(candidate, explained, number))
        joints = {f.candidate.joint for f in found}
        top = {k: max(f.excess for f in found if f.candidate.joint == k) for k in joints}
        asked = [rows is None or not set(rows).isdisjoint(self.rows(f.candidate)) for f in found]
        better = [
            self._refined(f, n) if asked[n] and f.excess > self.rules.refine * top[f.candidate.joint] else f
            for n, f in enumerate(found)
        ]
        ranked = sorted(better, key=lambda f: (self.p_value(f) > self.rules.level, -f.excess))
        return self.led_by(ranked[0], ranked)

    def best(self, effect: str, joint: int, answered: bool = False) -> Found | None:
        """An effect at a joint at its best values, whatever its rank; None when it cannot act there.

        answered   with parameters of its own at every speed
        """
        found = []
        for number, (family, at) in enumerate(self.families.members.items()):
            if family[:2] == (effect, joint) and family[3] == answered:
                X, limits = self.families.columns, self.families.bounds
                each = gains(self.base, [X[i] for i in at], [limits[i] for i in at])
                for candidate, i in self._by_gain(at, each)[:1]:
                    found.append(self._refined(self._found(candidate, each[i], number), number))
        return max(found, key=lambda f: f.excess, default=None)

    def _best_proper(self, family: Sequence[int], each: Sequence[Gain]) -> tuple[Candidate, Gain]:
        """A family's best whose values make it what its name says, if it takes more than chance."""
        for candidate, i in self._by_gain(family, each):
            if each[i].energy <= self.rules.chance**2 or self._proper(candidate, each[i]):
                return candidate, each[i]
        return self.examination.candidates[family[0]], replace(each[0], energy=0.0)

    def _by_gain(self, family: Sequence[int], each: Sequence[Gain]) -> list[tuple[Candidate, int]]:
        listed = [self.examination.candidates[i] for i in family]
        return of_whole_periods(self.robot, listed, [g.energy for g in each])

    def drives(self, further: Sequence[Candidate]) -> float:
        """Energy that no friction and no body has, over what the first has, beside all the others."""
        listed = [*self.chosen, *further]
        if not knows_sign(self.robot, further[0]):
            return 0.0
        p, x = self.fitted(listed)
        ends = np.cumsum([width(self.robot, c) for c in listed])[:-1]
        laws = list(zip(listed, np.split(x, ends), strict=True))
        return of_wrong_sign(self.robot, self.examination.logs, p, laws, further[0])

    def _proper(self, candidate: Candidate, explained: Gain) -> bool:
        if self.drives([candidate]) > self.rules.power:
            return False
        if law_of(self.robot, candidate).proper is None:
            return True
        p, _ = self.fitted([*self.chosen, candidate])
        parameters = dict(zip(self.robot.linear_parameters, p.tolist(), strict=True))
        period = max(log.band.period for log in self.examination.logs)
        return proper(self.robot, candidate, explained.coefficients.tolist(), parameters, period)

    def led_by(self, best: Found, ranked: Sequence[Found]) -> Step:
        """A ranking with `best` and those that cannot be told from it at its head, the simplest first.

        Laws of a machine are seldom quite the catalogue's, so that another may explain nearly as much as the
        best. Where the best leaves nothing, chance is all that may part them.
        """
        widest = max(self.rules.chance, best.spread)  # of what noise does to a gain, and of gains in replicas
        by_chance = self.rules.chance * widest
        surely, level, apart = best.excess - by_chance, self.rules.level, self.rules.apart
        least = min(self.rules.tie * best.excess, surely)
        near = [f for f in ranked if f is not best and f.excess >= least and self.p_value(f) <= level]
        tie = [best]
        if near:
            beside = extended(self.base, self.columns(best.candidate))
            left = self.examination.beyond_floor(beside, self.rows(best.candidate))
            near = [f for f in near if f.excess >= surely or left > by_chance]
            tie += [f for f in near if self.gain_of(f.candidate, beside).energy < apart * f.gain.energy]
        first, *others = self._simplest_first(tie)
        tie = self._without_generalisations([first, *(f for f in others if not f.other_form_of(first))])
        return Step(tuple(tie), self.p_value(tie[0]), tuple(f for f in ranked if f not in tie))

    def _simplest_first(self, tie: Sequence[Found]) -> list[Found]:
        """Further parameters must take away most of what fewer leave, else the law with fewer is as good."""
        first = tie[0]
        remaining = self.remaining_on(self.rows(first.candidate)) if len(tie) > 1 else 0.0
        for f in sorted(tie, key=lambda f: f.freedom):
            left, best_left = (max(remaining - g.excess, self.rules.chance**2) for g in (f, first))
            if f.freedom < first.freedom and best_left > self.rules.parameter * left:
                first = f
        return [first, *(f for f in tie if f is not first)]

    def _without_generalisations(self, tie: Sequence[Found]) -> list[Found]:
        """A law that is the first one and more is no rival of it: a spring with a preload, of an offset.

        What the catalogue calls a confounder stays: it does the same and is another thing.
        """
        first = tie[0]
        others = law_of(self.robot, first.candidate).confounders
        return [
            f
            for f in tie
            if f.freedom <= first.freedom or f.candidate.effect in others or not self._holds(f, first)
        ]

    def _holds(self, wider: Found, law: Found) -> bool:
        """Whether a law's columns are among those of a wider one."""
        return self.with_further([wider.candidate]).imitates(law.candidate)

    def imitates(self, candidate: Candidate) -> bool:
        """Whether what the search rests on does all that a candidate does."""
        return bool(np.isinf(self.gain_of(candidate).alone).all())

    def resolves(self, waves: Sequence[Candidate]) -> bool:
        """Whether the motion tells the orders of a joint's periodic law apart, and the least from none."""
        law = law_of(self.robot, waves[0]).order
        if law is None:
            return False
        orders = sorted(dict(c.values)[law.name] for c in waves)
        angles = np.concatenate([log.part.motion.q[:, waves[0].joint - 1] for log in self.examination.logs])
        return bool(np.diff([0.0, *orders]).min() * np.ptp(angles) >= 2 * np.pi)

    def gain_of(self, candidate: Candidate, base: Base | None = None) -> Gain:
        """What a candidate explains of a base's residual; none: of the present base's."""
        base = base or self.base
        return gain(base, self.columns(candidate), *bounds(self.robot, candidate))

    def p_value(self, found: Found) -> float:
        """Chance of such a score anywhere in the search with nothing missing (max-T over the replicas)."""
        return (1 + int((self.families.peaks >= found.z).sum())) / (1 + len(self.families.peaks))

    def columns(self, candidate: Candidate) -> Columns:
        """Per log: row -> (E, K)."""
        return columns(self.robot, candidate, self.examination.logs, self.levels)

    def rows(self, candidate: Candidate) -> list[int]:
        """The equations on which a candidate acts."""
        return sorted({c for log in self.columns(candidate) for c, X in log.items() if X.any()})

    @property
    def floor_energy(self) -> float:
        """Energy of the residual that replicas leave on average."""
        return float(self.examination.floor_energies.sum())

    @property
    def excess(self) -> float:
        """Energy that the data leave beyond it; 0 when they leave less."""
        return max(self.examination.base.energy - self.floor_energy, 0.0)

    def floor_energy_on(self, rows: Sequence[int]) -> float:
        """`floor_energy` of some equations only."""
        return float(self.examination.floor_energies[list(rows)].sum())

    @property
    def over_floor(self) -> np.ndarray:
        """(n,) energy that the present base leaves on each equation over that of replicas."""
        return over_floor(self.examination, self.base)

    def remaining_on(self, rows: Sequence[int]) -> float:
        """Energy that the present base leaves on some equations beyond what replicas do."""
        return self.examination.beyond_floor(self.base, rows)

    @cached_property
    def lacking(self) -> np.ndarray:
        """(n,) the same of each equation."""
        return np.array([self.remaining_on([row]) for row in range(len(self.robot.q))])

    def excess_in(self, region: Region) -> float:
        """`excess` in a region only."""
        return self.examination.beyond_floor_in(self.examination.base, region)

    def remaining_in(self, region: Region) -> float:
        """The same in a region."""
        return self.examination.beyond_floor_in(self.base, region)

    @property
    def stands_out(self) -> bool:
        """Whether the present base leaves by far more than replicas do on any equation."""
        return bool(self.standing_out.any())

    def stands_out_in(self, region: Region) -> bool:
        """Whether it does on rows of a region, and by that much within its bands."""
        if not self.standing_out[list(region.rows)].any():
            return False
        ex = self.examination
        floor = ex.excess(self.base.residual, region.inside(ex.bands), region.rows)[1]
        return self.remaining_in(region) > self.rules.stands_out * floor

    @property
    def standing_out(self) -> np.ndarray:
        """(n,) on which equations it does."""
        return standing_out(self.examination, self.base)

    def needed(self, family: int) -> float:
        """Gain a family (by number) would need to be named."""
        peak = float(np.quantile(self.families.peaks, 1 - self.rules.level))
        return float(
            self.families.mean[family]
            + max(peak * self.families.spread[family], self.rules.material * self.floor_energy)
        )

    def _found(self, candidate: Candidate, explained: Gain, family: int) -> Found:
        mean, spread = float(self.families.mean[family]), float(self.families.spread[family])
        return Found(candidate, explained, mean, spread)

    def _refined(self, found: Found, family: int) -> Found:
        """The same candidate with its nonlinear values between those of the grid."""
        listed = self.examination.candidates

        def explained(candidate: Candidate) -> float:
            return self.gain_of(candidate).energy

        better = refined(self.robot, found.candidate, listed, explained)
        taken = self.gain_of(better)
        if wants_no_period(self.robot, better, listed):
            return self._found(better, replace(taken, energy=0.0), family)
        return self._found(better, taken, family) if self._proper(better, taken) else found


def search_of(examination: Examination) -> Search:
    """A search among all candidates that rests on the model alone."""
    return Search(examination, families_of(examination), examination.base)
