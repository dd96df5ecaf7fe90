"""Parameters of a model of any kind by output error: the simulation that comes nearest to the logs.

Least squares of measured less simulated outputs (Ljung, System Identification, 2nd ed., sec. 7.2 and 10.2),
each output over its own noise, which is what is left of it; within bounds, by a trust region. The noise may
be coloured: the covariance follows from the long-run scatter of the scores (Newey and West 1987), or from the
spectrum of what is left.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from flexmodels.inputs import SimulationError
from pyident.estimation.instrumental_variables import Rows
from pyident.estimation.newey_west import LongRun
from pyident.greybox.recording import Progress, Recording, Simulate, require_numbers
from pyident.greybox.search import Derivatives, Free, Search
from pyident.refinement.instruments.residual_spectrum import spectral
from pyident.regression.machine.svd import svd
from pyident.rules.greybox import GREYBOX

_FINER = (0.1, 0.01)  # of that step: slopes by two must agree, or the outputs jump with the parameters
_ROUNDS = 3  # of weights
_BEGINNING = 20  # parts of a recording, the first of which is its beginning
_FELT = 1e-3  # of an output's size: the least miss that a beginning is held against
_FLOOR = 1e-9  # of an output's size: its least noise


Way = Literal["directional derivatives", "differences"]  # to the slopes of the outputs


@dataclass(frozen=True)
class Estimate:
    """std is nan where the logs do not tell the value by itself or nothing can be claimed."""

    free: Free
    value: float
    std: float
    determined: bool
    at_bound: bool
    slope: Way


@dataclass(frozen=True)
class OutputError:
    """estimates, residuals (N, S) per recording, and notes."""

    estimates: tuple[Estimate, ...]
    residuals: tuple[np.ndarray, ...]
    notes: tuple[str, ...]

    @property
    def values(self) -> dict[str, float]:
        return {e.free.name: e.value for e in self.estimates}


def output_error(
    recordings: Sequence[Recording],
    simulate: Simulate,
    free: Sequence[Free],
    progress: Progress | None = None,
    derivatives: Derivatives | None = None,
) -> OutputError:
    """Fit the free parameters. Raises SimulationError where the model cannot be simulated at its start.

    derivatives   the model's own; differences must confirm them where the search ends, else it goes on
    """
    search = Search(recordings, simulate, free, derivatives)
    p, notes = _start(search)
    p, left = _fitted(search, p, progress)
    if not search.confirm(p):
        p, left = _fitted(search, p, None)
    slopes, jumps = _settled_slopes(search, p)
    missed, few = _missed(search, left), _few(search)
    estimates = _judged(search, p, slopes, left, claims=not (jumps or missed or few))
    if jumps:
        notes += (
            "the outputs jump with the parameters (two widths of differences disagree): no interval is given",
        )
    if missed:
        notes += (
            f"a constant would explain more of {', '.join(missed)} than the fitted model does: check its "
            "unit, sign and start; no interval is given",
        )
    notes += (*few, *_begun_elsewhere(search, left), *_sizeless(estimates))
    notes += tuple(f"{e.free.name} ends at its bound {e.value:.6g}" for e in estimates if e.at_bound)
    return OutputError(estimates, tuple(left), (*notes, *((search.note,) if search.note else ())))


def _fitted(search: Search, p: np.ndarray, progress: Progress | None) -> tuple[np.ndarray, list[np.ndarray]]:
    """The parameters, and what is left; each output over what was left of it the round before."""
    from scipy.optimize import least_squares

    free = search.free
    left: list[np.ndarray] = []
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
    return p, left


def _begun_elsewhere(search: Search, left: Sequence[np.ndarray]) -> tuple[str, ...]:
    """A note where outputs are missed (N, S) at the beginning of their recordings far more than later on."""
    ratios = []
    for m in left:
        part = max(len(m) // _BEGINNING, 1)
        first, later = (np.sqrt(np.mean(x**2, axis=0)) for x in (m[:part], m[part:]))
        ratios.append(first / np.maximum(later, _FELT * search.size))
    names, most = search.recordings[0].outputs, np.max(ratios, axis=0)
    which = ", ".join(n for n, ratio in zip(names, most, strict=True) if ratio > GREYBOX.begun)
    said = f"{which}: missed at the beginning {most.max():.2g} times as much as later; where a log begins in "
    return (f"{said}motion, name the start values of the model's states as parameters, too",) if which else ()


def _sizeless(estimates: Sequence[Estimate]) -> tuple[str, ...]:
    """Notes on values that are smaller than what differences of them see."""
    names = [e.free.name for e in estimates if e.free.sizeless and abs(e.value) < GREYBOX.tiny]
    said = "starts at 0 without bounds, so that nothing tells its size: give them"
    return tuple(f"{name} {said} ({name}=LOW:HIGH)" for name in names)


def _few(search: Search) -> tuple[str, ...]:
    """A note where what moves in the logs is too little to tell its noise."""
    count = int(sum(len(r.measured) for r in search.recordings) * search.moves.sum())
    if count >= GREYBOX.few * len(search.free):
        return ()
    moving = "samples" if search.moves.all() else "samples of outputs that move in the logs"
    return (f"{count} {moving} for {len(search.free)} parameters: no interval is given",)


def _missed(search: Search, left: Sequence[np.ndarray]) -> list[str]:
    """Outputs of which more is left (N, S) per recording than they vary."""
    scatter = np.concatenate([m - m.mean(axis=0) for m in left]).std(axis=0)
    names = search.recordings[0].outputs
    return [n for n, s, size in zip(names, scatter, search.size, strict=True) if s > GREYBOX.worse * size]


def _settled_slopes(search: Search, p: np.ndarray) -> tuple[np.ndarray, bool]:
    """Slopes that a ten times finer difference confirms; and whether there are none."""
    slopes = search.slopes(p)
    others = [i for i in range(len(p)) if i not in search.own]
    for part in _FINER if others else ():
        finer = search.slopes(p, part)
        gap = np.linalg.norm((slopes - finer)[:, others])
        if gap <= GREYBOX.smooth * np.linalg.norm(slopes[:, others]):
            return finer, False
        slopes = finer
    return slopes, bool(others)


def _start(search: Search) -> tuple[np.ndarray, tuple[str, ...]]:
    """The model's own start, or a better one of a few within finite bounds."""
    from scipy.stats import qmc

    free = search.free
    p = np.array([np.clip(f.start, f.low, f.high) for f in free])
    missed = search.misses([p])[0]
    require_numbers(search.recordings, missed)
    furthest = max(float(np.max(np.abs(m) / search.size)) for m in missed)
    if not furthest < GREYBOX.away:
        raise SimulationError(
            f"{search.recordings[0].source}: the model's outputs grow without bound at its own start; check "
            "that the log's time is in seconds and its inputs are in the model's units, or start elsewhere"
        )
    search.set_worst(search.stacked(missed))
    if not all(np.isfinite([f.low, f.high]).all() for f in free):
        return p, ()
    spread = qmc.LatinHypercube(len(free), rng=0).random(GREYBOX.starts)
    low, high = (np.array([getattr(f, side) for f in free]) for side in ("low", "high"))
    tried = [p, *(low + u * (high - low) for u in spread)]
    cost = [float(np.sum(search.residual(q) ** 2)) for q in tried]
    best = int(np.argmin(cost))
    nearest = "the best of them was nearer than the model's own" if best else "the model's own was nearest"
    return tried[best], (f"{GREYBOX.starts} starts within the bounds were tried; {nearest}",)


def _judged(
    search: Search, p: np.ndarray, slopes: np.ndarray, left: Sequence[np.ndarray], claims: bool
) -> tuple[Estimate, ...]:
    at_bound = [
        min(abs(v - f.low), abs(f.high - v)) <= GREYBOX.at_bound * max(abs(v), f.size)
        for f, v in zip(search.free, p, strict=True)
    ]
    inside = ~np.array(at_bound)
    std, determined = np.full(len(p), np.nan), np.zeros(len(p), dtype=bool)
    if inside.any():
        variances, seen = _variances(search, slopes[:, inside], left)
        determined[inside] = seen
        if claims:
            std[inside] = np.where(seen, np.sqrt(np.maximum(variances, 0)), np.nan)
    return tuple(
        Estimate(f, float(v), float(s), bool(d) or bool(b), bool(b), way)
        for f, v, s, d, b, way in zip(search.free, p, std, determined, at_bound, _ways(search), strict=True)
    )


def _ways(search: Search) -> list[Way]:
    own = search.own
    return ["directional derivatives" if i in own else "differences" for i in range(len(search.free))]


def _variances(
    search: Search, slopes: np.ndarray, left: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """(P,) under coloured noise; and which parameters the outputs tell by themselves.

    The larger of two. That of noise which is uneven in time (Newey and West) is too small where few samples
    tell a parameter, as the fit has bent to their noise; that of noise which is the same all the time goes by
    its spectrum.
    """
    scale = np.linalg.norm(slopes, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    _, s, Vt = svd(slopes / scale)
    blind = Vt[s <= GREYBOX.unseen * max(s[0], np.finfo(float).tiny)]
    seen = (np.linalg.norm(blind, axis=0) < 1e-3) & (np.linalg.norm(slopes, axis=0) > 0)
    inverse = np.where(s > GREYBOX.unseen * s[0], 1 / np.maximum(s, np.finfo(float).tiny), 0)
    bread = (Vt.T * inverse**2) @ Vt
    uneven, even, first = np.zeros_like(bread), np.zeros_like(bread), 0
    for m in left:
        rows = (slopes[first : first + m.size] / scale).reshape(*m.shape, -1)
        first += m.size
        noise = m / search.noise
        run = LongRun(rows.shape[2], lags(m))
        run.add((rows * noise[:, :, None]).sum(axis=1))
        uneven += run.sum
        even += _even_scatter(rows, noise)
    count, P = len(slopes), slopes.shape[1]
    variances = [np.diag(bread @ scatter @ bread) for scatter in (uneven, even)]
    return np.max(variances, axis=0) * count / max(count - P, 1) / scale**2, seen


def _even_scatter(rows: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(P, P) of the scores rows (N, S, P) times noise (N, S), whose spectrum is the same all the time."""
    outputs, P = rows.shape[1:]
    log = [Rows(rows, rows, noise, np.ones_like(noise))]
    return spectral(lambda: log, np.ones(outputs))(np.eye(P), np.zeros(P))


def lags(residual: np.ndarray) -> int:
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
