"""Weighted residuals of a model of any kind, and how they change with its free parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flexmodels.inputs import SimulationError
from pyident.greybox.recording import Recording, Simulate
from pyident.rules.greybox import GREYBOX

_STEP = 1e-3  # of a parameter's size: central differences
_START = 1e-6  # likewise, where only the start of the states is differenced
_FAILED = 1e3  # times the first residual: where the model cannot be simulated


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

    @property
    def sizeless(self) -> bool:
        """Whether nothing tells its size."""
        return self.start == 0 and not np.isfinite(self.high - self.low)


class Sensitivities(Protocol):
    """Derivatives of a recording's outputs by some parameters, (parameters, N, S), where the model has them.

    steps    parameter -> a small change of it. Raises SimulationError where there are none, as at an event.
    """

    def __call__(
        self, recording: Recording, values: Mapping[str, float], steps: Mapping[str, float]
    ) -> np.ndarray: ...


@dataclass(frozen=True)
class Derivatives:
    """The model's own, and the parameters by which it has them."""

    names: frozenset[str]
    along: Sensitivities


class Search:
    """Weighted residuals and their slopes; remembers what is costly."""

    def __init__(
        self,
        recordings: Sequence[Recording],
        simulate: Simulate,
        free: Sequence[Free],
        derivatives: Derivatives | None = None,
    ):
        self.recordings, self.simulate, self.free = recordings, simulate, free
        self.derivatives, self.note = derivatives, ""
        measured = [r.measured for r in recordings]
        size = np.sqrt(np.mean(np.concatenate([m - m.mean(axis=0) for m in measured]) ** 2, axis=0))
        self.moves = size > 0
        self.size = np.where(self.moves, size, 1.0)
        self.noise = self.size.copy()
        self.worst = _FAILED
        self._latest: tuple[bytes, list[np.ndarray]] | None = None

    @property
    def own(self) -> list[int]:
        """Places of the parameters whose slopes are the model's own derivatives."""
        names = self.derivatives.names if self.derivatives else frozenset()
        return [i for i, f in enumerate(self.free) if f.name in names]

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

    def set_worst(self, first: np.ndarray) -> None:
        """By the residual at the start."""
        self.worst = _FAILED * max(float(np.abs(first).max()), 1.0)

    def residual(self, p: np.ndarray) -> np.ndarray:
        """A model that cannot be simulated there is far away."""
        count = sum(r.measured.size for r in self.recordings)
        try:
            flat = self.stacked(self.misses([p])[0])
        except SimulationError:
            return np.full(count, self.worst)
        return np.clip(np.nan_to_num(flat, nan=self.worst), -self.worst, self.worst)

    def slopes(self, p: np.ndarray, part: float = 1.0) -> np.ndarray:
        """(rows, P) of the weighted residual: the model's own derivatives, else differences.

        part   of the usual width of differences
        """
        derived = self._derived(p)
        others = [i for i in range(len(p)) if i not in self.own]
        columns = np.empty((sum(r.measured.size for r in self.recordings), len(p)))
        if others:
            columns[:, others] = self.differences(p, others, part)
        if self.own:
            columns[:, self.own] = derived
        return columns

    def differences(self, p: np.ndarray, places: Sequence[int], part: float = 1.0) -> np.ndarray:
        """(rows, places) by central differences within the bounds."""
        low, high = (np.array([getattr(f, side) for f in self.free]) for side in ("low", "high"))
        steps = part * _STEP * self._sizes(p)
        ends = [np.clip(p + s * steps, low, high) for s in (1, -1)]
        sets = [np.where(np.arange(len(p)) == i, end, p) for i in places for end in ends]
        flat = [self.stacked(self._bounded(m)) for m in self.misses(sets)]
        width = np.maximum(ends[0] - ends[1], np.finfo(float).tiny)
        return np.column_stack([(flat[2 * k] - flat[2 * k + 1]) / width[i] for k, i in enumerate(places)])

    def _bounded(self, misses: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Without what a model that grows without bound misses: squares of its slopes would overflow."""
        most = GREYBOX.away * self.size
        return [np.clip(np.nan_to_num(m, nan=0.0), -most, most) for m in misses]

    def confirm(self, p: np.ndarray) -> bool:
        """Whether differences agree with the model's own derivatives; if not, these are not used any more."""
        own = self.own
        if not own:
            return True
        derived = self.slopes(p)[:, own]
        if own != self.own:
            return False
        differences = self.differences(p, own)
        gap = np.linalg.norm(derived - differences, axis=0)
        wrong = gap > GREYBOX.smooth * np.linalg.norm(differences, axis=0)
        if not wrong.any():
            return True
        names = ", ".join(self.free[i].name for i, bad in zip(own, wrong, strict=True) if bad)
        self._abandon(f"they disagree with differences for {names}")
        return False

    def _derived(self, p: np.ndarray) -> np.ndarray:
        """(rows, own)."""
        own = self.own
        if not own or self.derivatives is None:
            return np.empty((0, 0))
        if self._latest is None or self._latest[0] != p.tobytes():
            steps = {self.free[i].name: float(_START * self._sizes(p)[i]) for i in own}
            try:
                rows = [self.derivatives.along(r, self.named(p), steps) for r in self.recordings]
            except SimulationError as error:
                self._abandon(str(error))
                return np.empty((0, 0))
            self._latest = p.tobytes(), rows
        courses = self._latest[1]
        return np.column_stack([-self.stacked([course[k] for course in courses]) for k in range(len(own))])

    def _sizes(self, p: np.ndarray) -> np.ndarray:
        return np.array([max(abs(v), 0.1 * f.size) for f, v in zip(self.free, p, strict=True)])

    def _abandon(self, why: str) -> None:
        self.derivatives = None
        self.note = f"slopes are differences, since the FMU's directional derivatives do not serve: {why}"
