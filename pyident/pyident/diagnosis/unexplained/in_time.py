"""Whether what is left of an equation lies in one short stretch of one log: something touched the arm.

The equation's coefficients over their floor go back to a course of time. A stretch's energy counts less what
the floor has in as long a time, over what all logs leave beyond their floor.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyident.regression.spectrum import Band, Equations
from pyident.rules.unexplained import UnexplainedRules

_WINDOWS = (0.5, 1.0, 2.0, 4.0)  # s


@dataclass(frozen=True)
class Stretch:
    """Number of a log, from and to [s] after its start, and the share of what is left that lies there."""

    log: int
    start: float
    end: float
    share: float


def one_stretch(
    logs: Sequence[Equations], residual: Sequence[np.ndarray], floor: float, rules: UnexplainedRules
) -> Stretch | None:
    """The shortest that holds most of an equation's excess; None where none does.

    residual   per log (2 bins,) over its level;  floor: energy that all logs leave by chance
    """
    courses = [np.square(course(e.band, r, len(e.part.target))) for e, r in zip(logs, residual, strict=True)]
    count = sum(map(len, courses))
    total = float(sum(x.sum() for x in courses))
    if total <= 2 * floor:
        return None
    sums = [np.append(0.0, np.cumsum(x)) for x in courses]
    for window in _WINDOWS:
        found: list[Stretch] = []
        for number, (e, until) in enumerate(zip(logs, sums, strict=True)):
            n = max(round(window / e.band.period), 1)
            if n <= rules.stretch * count and n < len(until):
                energy = until[n:] - until[:-n]
                at = int(np.argmax(energy))
                share = (float(energy[at]) - floor * n / count) / (total - floor)
                found.append(Stretch(number, at * e.band.period, at * e.band.period + window, share))
        best = max(found, key=lambda stretch: stretch.share, default=None)
        if best is not None and best.share >= rules.stretch_share:
            return best
    return None


def course(band: Band, coefficients: np.ndarray, samples: int) -> np.ndarray:
    """(samples,) of coefficients (2 bins,), real over imaginary parts: `Band.transform` backwards."""
    lines = np.zeros(band.length // 2 + 1, complex)
    lines[: band.bins] = coefficients[: band.bins] + 1j * coefficients[band.bins :]
    return np.fft.irfft(lines * np.sqrt(band.length / 2), band.length)[:samples]
