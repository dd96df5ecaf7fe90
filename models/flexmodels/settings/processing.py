"""How logged signals are named and prepared."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Column:
    """Where a signal of the log comes from in a foreign file: its name there and a gain to SI."""

    source: str
    gain: float = 1.0


@dataclass(frozen=True)
class Processing:
    """How logged signals are prepared.

    derivative   "central" or "hat"; None takes hat means for a held torque and central differences else
    cutoff       [Hz] of a zero-phase Butterworth of `order`, None for no filter
    decimate     factor by which the filtered equations are thinned out
    band         [Hz] up to which a diagnosis judges the equations, None: as far as they are sound
    dead_zone    speed [rad/s or m/s] below which the sign of a measured speed is noise: dry friction is
                 taken as proportional to the speed there, and thinned equations at rest are left out
    """

    derivative: Literal["central", "hat"] | None = None
    cutoff: float | None = None
    order: int = 4
    decimate: int = 1
    band: float | None = None
    dead_zone: float = 0.0

    @property
    def filters(self) -> bool:
        """Whether it filters or thins out, which says at what rate its logs are meant to come."""
        return self.cutoff is not None or self.decimate > 1
