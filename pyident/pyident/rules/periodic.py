"""Thresholds of the search for periods in a residual: which orders and frequencies, and what is a peak."""

from dataclasses import dataclass

from pyident.rules.rule import in_range, rule

_FORCES = "by hand; half or twice changes none of six hidden forces (tests/diagnosis/test_unexplained.py)"
_TIME = "by hand: time only"


@dataclass(frozen=True)
class PeriodicRules:
    """Orders are per turn of a joint; a neighbour is the next order or frequency that is tried."""

    lowest: float = rule(
        5.0,
        "orders that are tried apart",
        "below, a law's own grid is fine enough",
        "by hand; of the waves of tests/diagnosis/test_periodic.py twice as much loses an order of 7",
    )
    highest: float = rule(1000.0, "orders that a law is tried at", "a harmonic drive's teeth, twice", "gears")
    fastest: float = rule(
        0.8, "the Nyquist frequency, at the joint's median speed", "above, an order has an alias", "by reason"
    )
    highest_unexplained: int = rule(1000, "orders of an unexplained residual", "as `highest`", "gears")
    neighbours: int = rule(
        101,
        "neighbours that a peak counts against",
        "fewer hold the peak itself",
        "60 pairs of drawn logs of 20 s: a wave of 0.3 of the noise is found in 98 % (half: 90)",
    )
    speeds: int = rule(
        16,
        "parts of a joint's speeds, in each of which a wave may have another size and phase",
        "a resonance is narrow, and turns the phase round with the direction",
        "by reason, after ripples that shake an arm",
    )
    teeth: float = rule(
        30.0,
        "orders from which a wave may have a size of its own at every speed",
        "below, it is friction over the angle as well; a law's own grid ends there",
        "by reason, after friction over the angle that came out as such a wave",
    )
    answered: float = rule(
        2.0,
        "a chance peak of the sum over these parts",
        "the noise of a loop has broad hills, which are no waves",
        "by reason, after hills of 1.2 in logs with nothing hidden; waves that shake an arm have 3 to 15",
    )
    quiet: float = rule(20.0, "percent of the neighbours: noise", "others are skirts of the peak", _FORCES)
    chance: float = rule(0.001, "chance of such a peak in a spectrum", "many joints and logs", "convention")
    peaks: int = rule(3, "peaks of a joint that laws are tried at", "each costs a candidate", _TIME)
    left: float = rule(0.05, "a wave that the base leaves", "what it imitates is the motion itself", _FORCES)

    def __post_init__(self) -> None:
        in_range(self, "periodic", 0, 1, "fastest", "chance", "left")
        in_range(self, "periodic", 0, 100, "quiet")
        in_range(self, "periodic", 3, 10_001, "neighbours")
