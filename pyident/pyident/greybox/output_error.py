"""Parameters of a model of any kind by output error: the simulation that comes nearest to the logs.

Least squares of measured less simulated outputs (Ljung, System Identification, 2nd ed., sec. 7.2 and 10.2),
each output over its own noise, which is what is left of it; within bounds, by a trust region. The noise may
be coloured: the covariance follows from the long-run scatter of the scores (Newey and West 1987).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmodels.inputs import SimulationError
from pyident.estimation.newey_west import LongRun
from pyident.greybox.recording import Progress, Recording, Simulate
from pyident.rules.greybox import GREYBOX

_STEP = 1e-3  # of a parameter's size: central differences
_FINER = (0.1, 0.01)  # of that step: slopes by two must agree, or the outputs jump with the parameters
_ROUNDS = 3  # of weights
_FAILED = 1e3  # times the first residual: where the model cannot be simulated
_FLOOR = 1e-9  # of an output's size: its least noise


@dataclass(frozen=True)
class Free:
    """A parameter to be identified, from `start` on, between its bounds (infinite: none)."""

    name: str
    unit: str
    start: float
    low: float = -np.inf
    high: float = np.inf

    @property
    def size(self) -> float:
        """Of what a small change is a part."""
        spans = self.high - self.low
        return abs(self.start) or (spans if np.isfinite(spans) else 1.0)


@dataclass(frozen=True)
class Estimate:
    """std is nan where the logs do not tell the value by itself or nothing can be claimed."""

    free: Free
    value: float
    std: float
    determined: bool
    at_bound: bool


@dataclass(frozen=True)
class OutputError:
    """estimates, residuals (N, S) per recording, and notes."""

    estimates: tuple[Estimate, ...]
    residuals: tuple[np.ndarray, ...]
    notes: tuple[str, ...]

    @property
    def values(self) -> dict[str, float]:
        return {e.free.name: e.value for e in self.estimates}


class _Search:
    """Weighted residuals and their slopes; remembers what is costly."""

    def __init__(self, recordings: Sequence[Recording], simulate: Simulate, free: Sequence[Free]):
        self.recordings, self.simulate, self.free = recordings, simulate, free
        measured = [r.measured for r in recordings]
        size = np.sqrt(np.mean(np.concatenate([m - m.mean(axis=0) for m in measured]) ** 2, axis=0))
        self.size = np.where(size > 0, size, 1.0)
        self.noise = self.size.copy()
        self.worst = _FAILED

    def named(self, p: np.ndarray) -> dict[str, float]:
        return {f.name: float(v) for f, v in zip(self.free, p, strict=True)}

    def misses(self, sets: Sequence[np.ndarray]) -> list[list[np.ndarray]]:
        """Per set, per recording (N, S). Raises SimulationError."""
        named = [self.named(p) for p in sets]
        runs = [self.simulate(r, named, r.outputs) for r in self.recordings]
        return [
            [r.measured - run[i] for r, run in zip(self.recordings, runs, strict=True)]
            for i in range(len(sets))
        ]

    def stacked(self, misses: Sequence[np.ndarray]) -> np.ndarray:
        return np.concatenate([(m / self.noise).ravel() for m in misses])

    def residual(self, p: np.ndarray) -> np.ndarray:
        """A model that cannot be simulated there is far away."""
        count = sum(r.measured.size for r in self.recordings)
        try:
            flat = self.stacked(self.misses([p])[0])
        except SimulationError:
            return np.full(count, self.worst)
        return np.clip(np.nan_to_num(flat, nan=self.worst), -self.worst, self.worst)

    def slopes(self, p: np.ndarray, part: float = 1.0) -> np.ndarray:
        """(rows, P) of the weighted residual, by differences within the bounds."""
        low, high = (np.array([getattr(f, side) for f in self.free]) for side in ("low", "high"))
        steps = (
            part * _STEP * np.array([max(abs(v), 0.1 * f.size) for f, v in zip(self.free, p, strict=True)])
        )
        ends = [np.clip(p + s * steps, low, high) for s in (1, -1)]
        sets = [np.where(np.arange(len(p)) == i, end, p) for i in range(len(p)) for end in ends]
        flat = [self.stacked(m) for m in self.misses(sets)]
        width = np.maximum(ends[0] - ends[1], np.finfo(float).tiny)
        return np.column_stack([(flat[2 * i] - flat[2 * i + 1]) / width[i] for i in range(len(p))])


def output_error(
    recordings: Sequence[Recording],
    simulate: Simulate,
    free: Sequence[Free],
    progress: Progress | None = None,
) -> OutputError:
    """Fit the free parameters. Raises SimulationError where the model cannot be simulated at its start."""
    from scipy.optimize import least_squares

    search = _Search(recordings, simulate, free)
    p, notes = _start(search)
    bounds: Any = ([f.low for f in free], [f.high for f in free])
    for number in range(_ROUNDS):
        solution = least_squares(
            search.residual,
            p,
            jac=search.slopes,  # pyright: ignore[reportArgumentType]
            bounds=bounds,
            x_scale="jac",
            max_nfev=60,
        )
        p = np.asarray(solution.x)
        left = search.misses([p])[0]
        noise = np.maximum(np.sqrt(np.mean(np.concatenate(left) ** 2, axis=0)), _FLOOR * search.size)
        settled = np.allclose(noise, search.noise, rtol=0.02)
        search.noise = noise
        if progress:
            progress((number + 1) / (_ROUNDS + 1))
        if settled:
            break
    slopes, jumps = _settled_slopes(search, p)
    estimates = _judged(search, p, slopes, left, claims=not jumps)
    if jumps:
        notes += (
            "the outputs jump with the parameters (two widths of differences disagree): no interval is given",
        )
    notes += tuple(f"{e.free.name} ends at its bound {e.value:.6g}" for e in estimates if e.at_bound)
    return OutputError(estimates, tuple(left), notes)


def _settled_slopes(search: _Search, p: np.ndarray) -> tuple[np.ndarray, bool]:
    """Slopes that a ten times finer difference confirms; and whether there are none."""
    slopes = search.slopes(p)
    for part in _FINER:
        finer = search.slopes(p, part)
        if np.linalg.norm(slopes - finer) <= GREYBOX.smooth * np.linalg.norm(slopes):
            return finer, False
        slopes = finer
    return slopes, True


def _start(search: _Search) -> tuple[np.ndarray, tuple[str, ...]]:
    """The model's own start, or a better one of a few within finite bounds."""
    from scipy.stats import qmc

    free = search.free
    p = np.array([np.clip(f.start, f.low, f.high) for f in free])
    first = np.abs(search.stacked(search.misses([p])[0]))
    search.worst = _FAILED * max(float(first.max()), 1.0)
    if not all(np.isfinite([f.low, f.high]).all() for f in free):
        return p, ()
    spread = qmc.LatinHypercube(len(free), rng=0).random(GREYBOX.starts)
    low, high = (np.array([getattr(f, side) for f in free]) for side in ("low", "high"))
    tried = [p, *(low + u * (high - low) for u in spread)]
    cost = [float(np.sum(search.residual(q) ** 2)) for q in tried]
    best = int(np.argmin(cost))
    origin = "model" if best == 0 else "best of them"
    note = f"{GREYBOX.starts} starts within the bounds were tried; the {origin}"
    return tried[best], (
        note + (" own start was nearest" if best == 0 else " was nearer than the model's own"),
    )


def _judged(
    search: _Search, p: np.ndarray, slopes: np.ndarray, left: Sequence[np.ndarray], claims: bool
) -> tuple[Estimate, ...]:
    at_bound = [
        min(abs(v - f.low), abs(f.high - v)) <= GREYBOX.at_bound * max(abs(v), f.size)
        for f, v in zip(search.free, p, strict=True)
    ]
    inside = ~np.array(at_bound)
    std, determined = np.full(len(p), np.nan), np.zeros(len(p), dtype=bool)
    if inside.any():
        covariance, seen = _covariance(search, slopes[:, inside], left)
        determined[inside] = seen
        if claims:
            std[inside] = np.where(seen, np.sqrt(np.maximum(np.diag(covariance), 0)), np.nan)
    return tuple(
        Estimate(f, float(v), float(s), bool(d) or bool(b), bool(b))
        for f, v, s, d, b in zip(search.free, p, std, determined, at_bound, strict=True)
    )


def _covariance(
    search: _Search, slopes: np.ndarray, left: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Under coloured noise; and which parameters the outputs tell by themselves."""
    scale = np.linalg.norm(slopes, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    _, s, Vt = np.linalg.svd(slopes / scale, full_matrices=False)
    blind = Vt[s <= GREYBOX.unseen * max(s[0], np.finfo(float).tiny)]
    seen = (np.linalg.norm(blind, axis=0) < 1e-3) & (np.linalg.norm(slopes, axis=0) > 0)
    inverse = np.where(s > GREYBOX.unseen * s[0], 1 / np.maximum(s, np.finfo(float).tiny), 0)
    bread = (Vt.T * inverse**2) @ Vt
    scatter, first = np.zeros_like(bread), 0
    for m in left:
        rows = slopes[first : first + m.size] / scale
        scores = (rows * (m / search.noise).ravel()[:, None]).reshape(*m.shape, -1).sum(axis=1)
        first += m.size
        run = LongRun(scores.shape[1], _lags(m))
        run.add(scores)
        scatter += run.sum
    count, P = len(slopes), slopes.shape[1]
    covariance = bread @ scatter @ bread * count / max(count - P, 1)
    return covariance / np.outer(scale, scale), seen


def _lags(residual: np.ndarray) -> int:
    """Twice as far as the residual is correlated, at least the rule of Newey and West (1994)."""
    n = len(residual)
    least = int(4 * (n / 100) ** (2 / 9)) + 1
    reach = 0
    for column in (residual - residual.mean(axis=0)).T:
        power = np.abs(np.fft.rfft(column, 2 * n)) ** 2
        correlation = np.fft.irfft(power)[:n]
        if correlation[0] <= 0:
            continue
        below = np.flatnonzero(correlation / correlation[0] < 2 / np.sqrt(n))
        reach = max(reach, int(below[0]) if len(below) else n)
    return min(max(least, 2 * reach), n // 4)


def fixed(values: Mapping[str, float], simulate: Simulate) -> Simulate:
    """The model with some values set for good."""

    def run(recording, sets, names, progress=None):
        return simulate(recording, [{**values, **s} for s in sets], names, progress)

    return run
