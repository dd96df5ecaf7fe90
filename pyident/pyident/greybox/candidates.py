"""What an output's residual may depend on: a delay, a periodic function of an angle, any signal.

Every candidate is a few columns; `kind` orders them by how little they assume: one number, two, many.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pyident.rules.confidence import PERIODS
from pyident.rules.stillness import stands_still

BINS = 16  # of a signal's quantiles
_DELAYS = (0.5, 1, 1.5, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)  # [samples], either way
_ORDERS = 120  # highest order per turn

Kind = Literal["constant", "delay", "order", "signal"]
PARSIMONY: tuple[Kind, ...] = ("constant", "delay", "order", "signal")


@dataclass(frozen=True)
class Candidate:
    """of: signal; at: delay [s], order [1/turn]; columns (n, K) per recording."""

    kind: Kind
    of: str
    at: float
    columns: tuple[np.ndarray, ...]


def candidates(
    times: Sequence[np.ndarray],
    simulated: Sequence[np.ndarray],
    signals: Mapping[str, Sequence[np.ndarray]],
    angles: Mapping[str, Sequence[np.ndarray]],
) -> Iterator[Candidate]:
    """For one output.

    simulated   its course (n,) per recording
    signals     name -> (n,) per recording, on which it may depend
    angles      those of the signals that are angles, in rad
    """
    yield from _delays(times, simulated)
    for name, values in angles.items():
        yield from _orders(name, values)
    for name, values in signals.items():
        if stands_still(*values):
            continue
        x = np.concatenate(values)
        edges = np.unique(np.quantile(x, np.linspace(0, 1, BINS + 1)[1:-1]))
        yield Candidate("signal", name, 0.0, tuple(_binned(v, edges) for v in values))


def delayed(time: np.ndarray, course: np.ndarray, delay: float) -> np.ndarray:
    """The course (n,) `delay` [s] later; its ends are held."""
    return np.interp(time - delay, time, course)


def _delays(times: Sequence[np.ndarray], simulated: Sequence[np.ndarray]) -> Iterator[Candidate]:
    period = float(times[0][1] - times[0][0])
    for samples in (s * d for d in _DELAYS for s in (1, -1)):
        at = samples * period
        columns = tuple((delayed(t, y, at) - y)[:, None] for t, y in zip(times, simulated, strict=True))
        if any(np.any(c) for c in columns):
            yield Candidate("delay", "", at, columns)


def _orders(name: str, values: Sequence[np.ndarray]) -> Iterator[Candidate]:
    if stands_still(*values):
        return
    span = max(float(np.ptp(v)) for v in values)
    lowest = int(np.ceil(PERIODS * 2 * np.pi / span))
    for n in range(lowest, _ORDERS + 1):
        columns = tuple(np.column_stack([np.cos(n * v), np.sin(n * v)]) for v in values)
        yield Candidate("order", name, float(n), columns)


def _binned(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    places = np.searchsorted(edges, values)
    return (places[:, None] == np.arange(len(edges) + 1)).astype(float)
