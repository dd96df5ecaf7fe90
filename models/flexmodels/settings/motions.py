"""What a robot file says of the motions that it is told to make."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Multisine:
    """Feed-forward torque: `lines` equally spaced frequencies [Hz], rms torque per joint [N m or N]."""

    rms: tuple[float, ...]
    lines: int
    lowest: float
    highest: float


@dataclass(frozen=True)
class Identification:
    """Each joint swings as swing/2 (1 - cos(2 pi t / period)) under a multisine torque."""

    swing: tuple[float, ...]
    period: float
    duration: float
    multisine: Multisine


@dataclass(frozen=True)
class Line:
    """The tip goes from `start` to `end` [m] in `duration` [s], at rest at both ends.

    Joints in `locked` (counted from 1) stay at 0.
    """

    start: tuple[float, ...]
    end: tuple[float, ...]
    duration: float
    locked: tuple[int, ...] = ()
