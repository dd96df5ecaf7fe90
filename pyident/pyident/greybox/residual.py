"""What the residual of a simulated output shows: white noise, a constant, or what it depends on.

A candidate counts by the share of the residual that it foretells on data it was not fitted to (four
contiguous parts, each foretold by the other three). Residuals are correlated in time, so chance is measured
on the residual itself, moved against the signals in a circle: the best candidate of all must beat the best of
all on such residuals, whichever it is there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from pyident.estimation.newey_west import LongRun
from pyident.greybox.candidates import PARSIMONY, Candidate, Kind, candidates, delayed
from pyident.greybox.output_error import lags
from pyident.rules.greybox import GREYBOX

_RIDGE = 1e-9


@dataclass(frozen=True)
class Finding:
    """A dependence of one output's residual.

    of       signals that explain it alike, the best first; empty for a delay or a constant
    at       constant [unit of the output], delay [s], order [1/turn]; 0 for a signal
    size     rms of the part [unit of the output]
    share    of the residual's energy that it foretells, percent
    p_value  of so large a share for any candidate by chance
    """

    output: str
    kind: Kind
    of: tuple[str, ...]
    at: float
    size: float
    share_percent: float
    p_value: float


@dataclass(frozen=True)
class Shown:
    """Per output: rms of the residual, p-value of white noise, and what it depends on."""

    output: str
    unit: str
    rms: float
    white_p: float
    findings: tuple[Finding, ...]


def shown(
    output: str,
    unit: str,
    times: Sequence[np.ndarray],
    residuals: Sequence[np.ndarray],
    simulated: Sequence[np.ndarray],
    signals: Mapping[str, Sequence[np.ndarray]],
    angles: Mapping[str, Sequence[np.ndarray]],
    outputs: int,
    late: bool = True,
) -> Shown:
    """Examine one output of `outputs`; all sequences are per recording, (n,). late: a delay may be told.

    angles   those of the signals that are angles, in rad
    """
    mean = float(np.mean(np.concatenate(residuals)))
    left = [r - mean for r in residuals]
    rms = float(np.sqrt(np.mean(np.concatenate(residuals) ** 2)))
    told = rms > GREYBOX.rounding * float(np.sqrt(np.mean(np.concatenate(simulated) ** 2)))
    white = whiteness(left) if told else 1.0
    found: list[Finding] = []
    if told:
        listed = [c for c in candidates(times, simulated, signals, angles) if late or c.kind != "delay"]
        whole = sum(float(r @ r) for r in residuals)
        for _ in range(GREYBOX.terms):
            finding, part = _best(output, listed, left, outputs)
            if finding is None:
                break
            if finding.kind == "delay":
                finding, part = _refined(finding, times, left, simulated)
            energy = sum(float(r @ r) for r in left)
            left = [r - p for r, p in zip(left, part, strict=True)]
            scaled = finding.share_percent * energy / whole
            found.append(Finding(**{**finding.__dict__, "share_percent": scaled}))
        found += _constant(output, mean, left, rms)  # last: a function of a signal has a constant, too
    return Shown(output, unit, rms, white, tuple(found))


def deviations(left: Sequence[np.ndarray]) -> float:
    """Standard deviation of the mean of what is left (n,) per recording, whose noise may be coloured.

    The larger of two: by its correlation (Newey and West), and by how far the means of its quarters scatter.
    """
    count = sum(len(r) for r in left)
    total = 0.0
    for r in left:
        run = LongRun(1, lags(r[:, None]))
        run.add((r - r.mean())[:, None])
        total += max(float(run.sum[0, 0]), float(np.sum((r - r.mean()) ** 2)))
    pieces = (np.array_split(r, min(GREYBOX.folds, len(r))) for r in left)
    parts = [part.mean() for split in pieces for part in split]
    return max(np.sqrt(total) / count, float(np.std(parts, ddof=1)) / np.sqrt(len(parts)))


def _constant(output: str, mean: float, left: Sequence[np.ndarray], rms: float) -> list[Finding]:
    """The mean, where it stands out of what is left without it and takes enough of the residual."""
    from scipy.stats import norm

    sigmas = abs(mean) / max(deviations(left), np.finfo(float).tiny)
    share = (mean / rms) ** 2
    if sigmas < GREYBOX.constant or share < GREYBOX.material:
        return []
    return [Finding(output, "constant", (), mean, abs(mean), 100 * share, 2 * float(norm.sf(sigmas)))]


def standing_out(outputs: Sequence[tuple[str, str]], residuals: Sequence[np.ndarray]) -> tuple[str, ...]:
    """A sentence per output (name, unit) whose residual (N, S) per recording has a mean that stands out."""
    found = []
    for s, (name, unit) in enumerate(outputs):
        own = [r[:, s] for r in residuals]
        mean, rms = float(np.mean(np.concatenate(own))), float(np.sqrt(np.mean(np.concatenate(own) ** 2)))
        if rms > 0 and _constant(name, mean, [r - mean for r in own], rms):
            size = f"{mean:.3g} {unit}".rstrip()
            found.append(f"what is left of {name} has a mean of {size}: a constant that the model has not")
    return tuple(found)


def coloured(outputs: Sequence[str], residuals: Sequence[np.ndarray]) -> tuple[str, ...]:
    """A sentence where what is left (N, S) per recording is no white noise: it may be what a model lacks."""
    each = [[r[:, s] - r[:, s].mean() for r in residuals] for s in range(len(outputs))]
    found = [n for n, own in zip(outputs, each, strict=True) if whiteness(own) * len(each) < GREYBOX.white]
    said = "intervals hold if that is noise, and not if the model lacks something (`diagnose` tells more)"
    return (f"what is left of {', '.join(found)} is no white noise: {said}",) if found else ()


def whiteness(residuals: Sequence[np.ndarray]) -> float:
    """p-value of white noise (Ljung and Box 1978), the smallest over the recordings times their number."""
    from scipy.stats import chi2

    smallest = 1.0
    for r in residuals:
        n, energy = len(r), float(r @ r)
        if energy == 0:
            continue
        lags = range(1, min(GREYBOX.lags, n // 4) + 1)
        correlation = np.array([float(r[k:] @ r[:-k]) / energy for k in lags])
        q = n * (n + 2) * np.sum(correlation**2 / (n - np.array(lags)))
        smallest = min(smallest, float(chi2.sf(q, len(correlation))))
    return min(1.0, smallest * len(residuals))


def _best(
    output: str, listed: Sequence[Candidate], left: Sequence[np.ndarray], outputs: int
) -> tuple[Finding | None, list[np.ndarray]]:
    """The candidate that foretells most, where chance does not; and its part of the residual."""
    rng = np.random.default_rng(0)
    shifts = max(GREYBOX.shifts, ceil(outputs / GREYBOX.level))
    moved = [_turned(r, shifts, rng) for r in left]
    folds = _parts(moved)
    shares = np.array([_share(c, folds) for c in listed])
    top, chance = shares[:, 0].max(), shares[:, 1:].max(axis=0)
    p = float((1 + np.sum(chance >= top)) / (1 + len(chance)))
    if p > GREYBOX.level / outputs or top < GREYBOX.material:
        return None, []
    near = [i for i in np.argsort(-shares[:, 0]) if shares[i, 0] >= GREYBOX.tie * top]
    kind = min((listed[i].kind for i in near), key=PARSIMONY.index)
    tied = [listed[i] for i in near if listed[i].kind == kind]
    names = tuple(dict.fromkeys(c.of for c in tied if c.of))[: GREYBOX.shown]
    best = tied[0]
    part = _fitted(best, left)
    size = float(np.sqrt(np.mean(np.concatenate(part) ** 2)))
    share = 100 * float(shares[listed.index(best), 0])
    return Finding(output, kind, names, best.at, size, share, p), part


def _turned(residual: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """(n, 1 + shifts): as it is, then moved in a circle by at least a twentieth of its length."""
    n = len(residual)
    shifts = rng.integers(n // 20, n - n // 20, count)
    return np.column_stack([residual, *(np.roll(residual, s) for s in shifts)])


def _parts(residuals: Sequence[np.ndarray]) -> list[list[tuple[int, slice, np.ndarray, np.ndarray]]]:
    """Per fold: recording, rows, residuals there and their energies."""
    folds: list[list[tuple[int, slice, np.ndarray, np.ndarray]]] = [[] for _ in range(GREYBOX.folds)]
    for i, R in enumerate(residuals):
        ends = np.linspace(0, len(R), GREYBOX.folds + 1).astype(int)
        for fold, begin, end in zip(folds, ends[:-1], ends[1:], strict=True):
            fold.append((i, slice(begin, end), R[begin:end], np.sum(R[begin:end] ** 2, axis=0)))
    return folds


def _share(candidate: Candidate, folds: list[list[tuple[int, slice, np.ndarray, np.ndarray]]]) -> np.ndarray:
    """Per column of the residuals: the share of its energy that is foretold."""
    grams, scores = [], []
    for fold in folds:
        blocks = [(candidate.columns[i][rows], R) for i, rows, R, _ in fold]
        grams.append(sum(X.T @ X for X, _ in blocks))
        scores.append(sum(X.T @ R for X, R in blocks))
    gram, score = sum(grams), sum(scores)
    gained, energy = 0.0, 0.0
    for fold, own_gram, own_score in zip(folds, grams, scores, strict=True):
        others = gram - own_gram
        ridge = _RIDGE * max(float(np.trace(others)), np.finfo(float).tiny) * np.eye(len(others))
        c = np.linalg.solve(others + ridge, score - own_score)
        if candidate.kind == "delay":
            c = np.ones_like(c)  # the course itself, later: nothing is scaled
        gained = gained + np.sum(c * (2 * own_score - own_gram @ c), axis=0)
        energy = energy + sum(e for *_, e in fold)
    return gained / np.maximum(energy, np.finfo(float).tiny)


def _fitted(candidate: Candidate, residuals: Sequence[np.ndarray]) -> list[np.ndarray]:
    if candidate.kind == "delay":
        return [columns[:, 0] for columns in candidate.columns]
    X, r = np.concatenate(candidate.columns), np.concatenate(residuals)
    coefficients = np.linalg.lstsq(X, r, rcond=None)[0]
    return [columns @ coefficients for columns in candidate.columns]


def _refined(
    finding: Finding, times: Sequence[np.ndarray], left: Sequence[np.ndarray], simulated: Sequence[np.ndarray]
) -> tuple[Finding, list[np.ndarray]]:
    """The delay between the tried ones."""
    from scipy.optimize import minimize_scalar

    def parts(delay: float) -> list[np.ndarray]:
        return [delayed(t, y, delay) - y for t, y in zip(times, simulated, strict=True)]

    def missed(delay: float) -> float:
        return sum(float(np.sum((r - p) ** 2)) for r, p in zip(left, parts(delay), strict=True))

    period = float(times[0][1] - times[0][0])
    width = max(0.5 * abs(finding.at), period)
    best = minimize_scalar(missed, bounds=(finding.at - width, finding.at + width), method="bounded")
    part = parts(float(best.x))  # pyright: ignore[reportAttributeAccessIssue]
    size = float(np.sqrt(np.mean(np.concatenate(part) ** 2)))
    return Finding(**{**finding.__dict__, "at": float(best.x), "size": size}), part  # pyright: ignore[reportAttributeAccessIssue]
