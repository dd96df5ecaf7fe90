"""Where a channel repeats its value."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Runs:
    """First sample and number of samples of every run of equal values."""

    start: np.ndarray
    length: np.ndarray


def runs(x: np.ndarray) -> Runs:
    start = np.concatenate([[0], np.flatnonzero(np.diff(x)) + 1])
    return Runs(start, np.diff(np.append(start, len(x))))
