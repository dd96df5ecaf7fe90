"""Which of the candidates explain the residual: one after the other, each beyond what replicas pretend."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from flexmodels.robot import Robot
from pyident.candidates import Candidate, bounds, columns, nonlinear_range
from pyident.evidence import Base, Columns, Gain, extended, gain
from pyident.examination import Examination

_TRIALS = 60  # of the nonlinear parameters of one candidate
_WORTH_REFINING = 0.3  # of the best gain
ALPHA = 0.05  # chance of a name when nothing is missing
_STANDS_OUT = 0.3  # of the floor's energy
MATERIAL = 0.005  # of the floor's energy: a gain below it is not worth a name
_TIE = 0.9  # of the best gain: what explains as much cannot be told from it


@dataclass(frozen=True)
class Found:
    """A candidate at its best nonlinear values. gain; `pretended`: the mean gain of its family in replicas."""

    candidate: Candidate
    gain: Gain
    pretended: float
    z: float

    @property
    def excess(self) -> float:
        return self.gain.energy - self.pretended


@dataclass(frozen=True)
class Step:
    """One step of the search: the tie, best first, p-value of its best, and the base with it."""

    tie: tuple[Found, ...]
    p_value: float
    others: tuple[Found, ...]


class Search:
    """The candidates of an examination against its base, which grows with what is accepted."""

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
        self.mean, self.spread = best.mean(axis=0), best.std(axis=0) + 1.0 + 0.5 * best.mean(axis=0)
        self.peaks = np.array([self._peak(best, b) for b in range(len(best))])

    def step(self) -> Step:
        """The best family, refined, those that cannot be told from it, and the others."""
        gains = [gain(self.base, X, *b) for X, b in zip(self._columns, self._bounds, strict=True)]
        found = []
        for number, (family, at) in enumerate(self.families.items()):
            best = max(at, key=lambda i: gains[i].energy)
            found.append(self._found(self.examination.candidates[best], gains[best], number))
        top = max(f.excess for f in found)
        refined = [self._refined(f, n) if f.excess > _WORTH_REFINING * top else f for n, f in enumerate(found)]
        ranked = sorted(refined, key=lambda f: (self.p_value(f) > ALPHA, -f.excess))
        best = ranked[0]
        tie = tuple(f for f in ranked if f.excess >= _TIE * best.excess and self.p_value(f) <= ALPHA) or (best,)
        return Step(tie, self.p_value(best), tuple(f for f in ranked if f not in tie))

    def best(self, effect: str, joint: int) -> Found | None:
        """An effect at a joint at its best values; None when it cannot act there."""
        found = []
        for number, (family, at) in enumerate(self.families.items()):
            if family[:2] == (effect, joint):
                gains = {i: gain(self.base, self._columns[i], *self._bounds[i]) for i in at}
                top = max(gains, key=lambda i: gains[i].energy)
                found.append(
                    self._refined(self._found(self.examination.candidates[top], gains[top], number), number)
                )
        return max(found, key=lambda f: f.excess, default=None)

    def p_value(self, found: Found) -> float:
        """Chance of such a score anywhere in the search with nothing missing (max-T over the replicas)."""
        return (1 + int((self.peaks >= found.z).sum())) / (1 + len(self.peaks))

    def rest_on(self, chosen: Sequence[Candidate]) -> None:
        """Take the examination's base with these candidates joined to it."""
        self.base = self.examination.base
        for candidate in chosen:
            self.base = extended(self.base, self.columns(candidate))

    def columns(self, candidate: Candidate) -> Columns:
        """Per log: row -> (E, K)."""
        return columns(self.robot, candidate, self.examination.logs, self.levels)

    @property
    def floor_energy(self) -> float:
        """Energy of the residual that replicas leave on average."""
        return float((self.examination.replica_energy.mean(axis=0) * self.examination.count).sum())

    @property
    def excess(self) -> float:
        """Energy that the data leave beyond it; 0 when they leave less."""
        return max(self.examination.base.energy - self.floor_energy, 0.0)

    @property
    def remaining(self) -> float:
        """The same with what was accepted."""
        return max(self.base.energy - self.floor_energy, 0.0)

    @property
    def explained(self) -> float:
        """Share of the excess that what was accepted takes away."""
        return (self.examination.base.energy - self.base.energy) / self.excess if self.excess else 1.0

    @property
    def stands_out(self) -> bool:
        """Whether the residual exceeds the replicas' by far, in all or in a band of a row."""
        ex = self.examination
        mean = ex.replica_energy.mean(axis=0)
        of_band = (ex.energy - mean) * ex.count
        return self.excess > _STANDS_OUT * self.floor_energy or bool((of_band > _STANDS_OUT * self.floor_energy).any())

    def needed(self, family: int) -> float:
        """Gain that a family (by its number) would need to be named."""
        peak = float(np.quantile(self.peaks, 0.95))
        return float(self.mean[family] + max(peak * self.spread[family], MATERIAL * self.floor_energy))

    def _found(self, candidate: Candidate, explained: Gain, family: int) -> Found:
        mean = float(self.mean[family])
        return Found(candidate, explained, mean, (explained.energy - mean) / float(self.spread[family]))

    def _peak(self, best: np.ndarray, b: int) -> float:
        """The largest score of one replica against the others."""
        rest = np.delete(best, b, axis=0)
        spread = rest.std(axis=0) + 1.0 + 0.5 * rest.mean(axis=0)
        return float(((best[b] - rest.mean(axis=0)) / spread).max())

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
        options = {"maxfev": _TRIALS, "initial_simplex": simplex, "xatol": 0.01, "fatol": 1e-4 * found.gain.energy}
        result = minimize(missed, np.zeros(len(names)), method="Nelder-Mead", bounds=ranges, options=options)
        better = candidate(np.asarray(result.x))
        return self._found(better, gain(self.base, self.columns(better), *limits), family)
