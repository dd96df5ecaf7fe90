"""How errors fall with an effect."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Step:
    """One pair of bars of a waterfall: an error of the base, with the effect, and the floor, rms in `unit`.

    data   the logs that it is taken on: those that were not used, or those that were fitted
    """

    name: str
    unit: str
    before: float
    after: float
    floor: float
    data: Literal["held out", "fitted"] = "held out"
