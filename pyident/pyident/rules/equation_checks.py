"""Thresholds by which a log's equations of motion are made and asked, before any is believed."""

from dataclasses import dataclass

from pyident.rules.rule import RulesError, in_range, rule

_FIXED = "by hand, on the logs of studies/log_checks as they were gathered; "
_SAME = f"{_FIXED}half or twice as much changes none"


@dataclass(frozen=True)
class EquationCheckRules:
    """What is filtered, what counts as moving, and how sure an answer has to be; shares are of one."""

    slow: float = rule(
        0.05,
        "a joint's rms speed",
        "below, the sign of friction is not known",
        f"{_FIXED}twice flags a good one",
    )
    stands: float = rule(
        3e-4, "the busiest joint's way", "less is a brake's play and an encoder's noise", _SAME
    )
    fewest_moving: int = rule(30, "samples on which a joint moves", "fewer say nothing", _SAME)
    energy: float = rule(
        0.99,
        "a speed's energy below the motion's highest frequency",
        "the rest is noise",
        f"{_FIXED}half misses two wrong ones and flags another",
    )
    above: float = rule(
        3.0,
        "the motion's highest frequency, that is kept",
        "torques have harmonics",
        f"{_FIXED}twice flags one more wrong one",
    )
    band: tuple[float, float] = rule(
        (0.05, 0.6),
        "the Nyquist frequency, for the filter's edge",
        "outside, a filter is none",
        f"{_FIXED}half flags three good ones",
    )
    settled: float = rule(
        3.0,
        "periods of the filter's edge at either end",
        "they are spoilt",
        f"{_FIXED}half flags one more wrong one",
    )
    determined: float = rule(
        1e-9, "the largest eigenvalue of the normal equations", "below, a direction is noise", _SAME
    )
    coloured: float = rule(
        2.0,
        "the standard deviation of white residuals",
        "neighbouring samples leave alike",
        f"{_FIXED}half refuses two good ones, twice flags one",
    )
    estimable: float = rule(
        1e-3, "a combination of parameters that the samples leave open", "more is a guess", _SAME
    )
    speaks: float = rule(
        0.05,
        "the torques' variance that the file's masses explain beyond all else",
        "with less, they say nothing of the unit",
        _SAME,
    )
    heavy: float = rule(
        0.05, "the largest joint's torque (energy) by the file", "a lighter one says little", _SAME
    )
    per_parameter: int = rule(10, "equations per parameter", "with fewer, anything fits", _SAME)
    room: float = rule(
        3.0,
        "rad or m",
        "smaller positions are neither degrees nor millimetres",
        "no data: what robots do; half flags a good log of studies/log_checks",
    )
    longest: float = rule(
        100.0,
        "m",
        "positions of sliders are no metres read as millimetres beyond",
        "no data: what sliders do; half or twice says the same of the logs of studies/log_checks",
    )
    longest_shift: float = rule(
        0.15,
        "s of a torque's delay, either way",
        "more is another log",
        f"{_FIXED}twice warns of one instead of refusing it",
    )
    most_shift: int = rule(60, "samples of the same", "time", _SAME)
    sure_delay: float = rule(
        3.0, "standard deviations from which a delay is corrected", "less may be chance", _SAME
    )

    def __post_init__(self) -> None:
        shares = ("slow", "stands", "energy", "determined", "estimable", "speaks", "heavy")
        in_range(self, "equation_checks", 0, 1, *shares)
        low, high = self.band
        if not 0 < low < high < 1:
            raise RulesError(
                f"rules: equation_checks.band goes from {low:g} to {high:g} of the Nyquist frequency; "
                "it must rise within 0 and 1"
            )


EQUATIONS = EquationCheckRules()
