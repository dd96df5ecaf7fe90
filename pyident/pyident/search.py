"""Which of the candidates explain the residual, beyond what replicas pretend."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from flexmodels.robot import Robot
from pyident.candidates import Candidate, bounds, columns, nonlinear_range
from pyident.evidence import Base, Columns, Gain, extended, gain
from pyident.examination import Examination

ALPHA = 0.05  # chance of a name when nothing is missing
_TRIALS = 60  # of the nonlinear parameters of one candidate
_WORTH_REFINING = 0.3  # of the best gain
_TIE = 0.9  # of the best gain: what explains as much cannot be told from it
_CHANCE = 5.0  # standard deviations by which a gain may differ by chance
_STANDS_OUT = 0.3  # of the floor's energy
_OWN_TRACE = 0.5  # of a family's mean gain in replicas: how well the method's own trace is known


@dataclass(frozen=True)
class Found:
    """A candidate at its best nonlinear values. `pretended`: its family's mean gain in replicas; z: score."""

    candidate: Candidate
    gain: Gain
    pretended: float
    z: float

    @property
    def excess(self) -> float:
        return self.gain.energy - self.pretended

    @property
    def freedom(self) -> int:
        """Number of parameters: of laws that explain alike, the one with fewer comes first."""
        return len(self.gain.coefficients) + len(self.candidate.values)


@dataclass(frozen=True)
class Step:
    """One ranking of all families. tie: the best, and what cannot be told from it; begins `ranked`."""

    tie: tuple[Found, ...]
    p_value: float
    others: tuple[Found, ...]

    @property
    def best(self) -> Found:
        return self.tie[0]

    @property
    def ranked(self) -> tuple[Found, ...]:
        return self.tie + self.others

    def led_by(self, found: Found) -> "Step":
        """The same ranking with another one as the best: its tie is what explains as much or nearly so."""
        if found is self.best:
            return self
        rest = [f for f in self.ranked if f is not found]
        equal = tuple(f for f in rest if _TIE <= f.excess / found.excess <= 1 / _TIE)
        return Step((found, *equal), self.p_value, tuple(f for f in rest if f not in equal))


class Search:
    """The candidates of an examination against its base, which may rest on some of them."""

    def __init__(self, examination: Examination):
        self.examination = examination
        self.robot: Robot = examination.setting.robot
        self.base: Base = examination.base
        self.levels = examination.levels
        self._columns: list[Columns] = [self.columns(c) for c in examination.candidates]
        self._bounds = [bounds(self.robot, c) for c in examination.candidates]
        families = [c.family for c in examination.candidates]
        self.families = {f: [i for i, g in enumerate(families) if g == f] for f in dict.fromkeys(families)}
        best = np.array([examination.replica_gains[:, at].max(axis=1) for at in self.families.values()]).T
        self.mean, self.spread = best.mean(axis=0), _spread(best)
        self.peaks = np.array([_peak(best, b) for b in range(len(best))])

    def rest_on(self, chosen: Sequence[Candidate]) -> None:
        """Take the examination's base with these candidates joined to it."""
        self.base = self.examination.base
        for candidate in chosen:
            self.base = extended(self.base, self.columns(candidate))

    def step(self) -> Step:
        """Rank the families by what they explain of the present base's residual."""
        gains = [gain(self.base, X, *b) for X, b in zip(self._columns, self._bounds, strict=True)]
        found = []
        for number, at in enumerate(self.families.values()):
            best = max(at, key=lambda i: gains[i].energy)
            found.append(self._found(self.examination.candidates[best], gains[best], number))
        top = max(f.excess for f in found)
        refined = [
            self._refined(f, n) if f.excess > _WORTH_REFINING * top else f for n, f in enumerate(found)
        ]
        ranked = sorted(refined, key=lambda f: (self.p_value(f) > ALPHA, -f.excess))
        best = ranked[0]
        least = max(_TIE * best.excess, best.excess - self._misfit(best))
        near = [f for f in ranked if f.excess >= least and self.p_value(f) <= ALPHA]
        tie = tuple(sorted(near or [best], key=lambda f: (f.freedom, -f.excess)))
        best = tie[0]
        return Step(tie, self.p_value(best), tuple(f for f in ranked if f not in tie))

    def best(self, effect: str, joint: int) -> Found | None:
        """An effect at a joint at its best values, whatever its rank; None when it cannot act there."""
        found = []
        for number, (family, at) in enumerate(self.families.items()):
            if family[:2] == (effect, joint):
                gains = {i: gain(self.base, self._columns[i], *self._bounds[i]) for i in at}
                top = max(gains, key=lambda i: gains[i].energy)
                start = self._found(self.examination.candidates[top], gains[top], number)
                found.append(self._refined(start, number))
        return max(found, key=lambda f: f.excess, default=None)

    def _misfit(self, found: Found) -> float:
        """What a candidate leaves on its own equations: a rival that is behind by no more stays in."""
        left = self.remaining_on(self.rows(found.candidate)) - found.excess
        return max(left, _CHANCE**2)

    def p_value(self, found: Found) -> float:
        """Chance of such a score anywhere in the search with nothing missing (max-T over the replicas)."""
        return (1 + int((self.peaks >= found.z).sum())) / (1 + len(self.peaks))

    def columns(self, candidate: Candidate) -> Columns:
        """Per log: row -> (E, K)."""
        return columns(self.robot, candidate, self.examination.logs, self.levels)

    def rows(self, candidate: Candidate) -> list[int]:
        """The equations on which a candidate acts."""
        return sorted({c for log in self.columns(candidate) for c, X in log.items() if X.any()})

    @property
    def floor_energy(self) -> float:
        """Energy of the residual that replicas leave on average."""
        return float(self._floor_energies.sum())

    @property
    def excess(self) -> float:
        """Energy that the data leave beyond it; 0 when they leave less."""
        return max(self.examination.base.energy - self.floor_energy, 0.0)

    @property
    def remaining(self) -> float:
        """The same of the present base."""
        return max(self.base.energy - self.floor_energy, 0.0)

    def excess_on(self, rows: Sequence[int]) -> float:
        """`excess` on some equations only."""
        return self._beyond_floor(self.examination.base, rows)

    def remaining_on(self, rows: Sequence[int]) -> float:
        """`remaining` on some equations only."""
        return self._beyond_floor(self.base, rows)

    @property
    def explained(self) -> float:
        """Share of the excess that the present base takes away."""
        return (self.examination.base.energy - self.base.energy) / self.excess if self.excess else 1.0

    @property
    def stands_out(self) -> bool:
        """Whether the residual exceeds the replicas' by far, in all or in a band of a row."""
        ex = self.examination
        of_band = (ex.energy - ex.replica_energy.mean(axis=0)) * ex.count
        return max(self.excess, float(of_band.max())) > _STANDS_OUT * self.floor_energy

    def needed(self, family: int, material: float) -> float:
        """Gain a family (by number) would need to be named; material: least gain over the floor's energy."""
        peak = float(np.quantile(self.peaks, 1 - ALPHA))
        return float(self.mean[family] + max(peak * self.spread[family], material * self.floor_energy))

    def _beyond_floor(self, base: Base, rows: Sequence[int]) -> float:
        left = sum(float(np.square(r[rows]).sum()) for r in base.residual)
        return max(left - float(self._floor_energies[rows].sum()), 0.0)

    @property
    def _floor_energies(self) -> np.ndarray:
        ex = self.examination
        return (ex.replica_energy.mean(axis=0) * ex.count).sum(axis=1)

    def _found(self, candidate: Candidate, explained: Gain, family: int) -> Found:
        mean = float(self.mean[family])
        return Found(candidate, explained, mean, (explained.energy - mean) / float(self.spread[family]))

    def _refined(self, found: Found, family: int) -> Found:
        """The same candidate with its nonlinear values between those of the grid."""
        if not found.candidate.values:
            return found
        limits = bounds(self.robot, found.candidate)
        names, start, low, high = nonlinear_range(self.robot, found.candidate, self.examination.candidates)

        def candidate(x: np.ndarray) -> Candidate:
            return found.candidate.at(dict(zip(names, (start + x * (high - low)).tolist(), strict=True)))

        def missed(x: np.ndarray) -> float:
            return -gain(self.base, self.columns(candidate(x)), *limits).energy

        ranges = list(zip((low - start) / (high - low), (high - start) / (high - low), strict=True))
        simplex = np.vstack([np.zeros(len(names)), 0.2 * np.eye(len(names))])
        options = {
            "maxfev": _TRIALS,
            "initial_simplex": simplex,
            "xatol": 0.01,
            "fatol": 1e-4 * found.gain.energy,
        }
        result = minimize(missed, np.zeros(len(names)), method="Nelder-Mead", bounds=ranges, options=options)
        better = candidate(np.asarray(result.x))
        return self._found(better, gain(self.base, self.columns(better), *limits), family)


def _spread(best: np.ndarray) -> np.ndarray:
    """(F,) how much a family's gain varies without cause: its noise, and how the method's trace varies."""
    return best.std(axis=0) + 1.0 + _OWN_TRACE * best.mean(axis=0)


def _peak(best: np.ndarray, b: int) -> float:
    """The largest score of one replica against the others."""
    rest = np.delete(best, b, axis=0)
    return float(((best[b] - rest.mean(axis=0)) / _spread(rest)).max())
