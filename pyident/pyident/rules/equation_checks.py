"""Thresholds by which a log's equations of motion are made and asked, before any is believed."""

from dataclasses import dataclass

from pyident.rules.rule import in_range, rule

_IN_USE = "not recorded; in use when studies/log_checks was scored"


@dataclass(frozen=True)
class EquationCheckRules:
    """What is filtered, what counts as moving, and how sure an answer has to be; shares are of one."""

    slow: float = rule(0.05, "a joint's rms speed", "below, the sign of friction is not known", _IN_USE)
    stands: float = rule(
        3e-4, "the busiest joint's way", "less is a brake's play and an encoder's noise", _IN_USE
    )
    fewest_moving: int = rule(30, "samples on which a joint moves", "fewer say nothing", _IN_USE)
    energy: float = rule(
        0.99, "a speed's energy below the motion's highest frequency", "the rest is noise", _IN_USE
    )
    above: float = rule(
        3.0, "the motion's highest frequency, that is kept", "torques have harmonics", _IN_USE
    )
    band: tuple[float, float] = rule(
        (0.05, 0.6), "the Nyquist frequency, for the filter's edge", "outside, a filter is none", _IN_USE
    )
    settled: float = rule(3.0, "periods of the filter's edge at either end", "they are spoilt", _IN_USE)
    determined: float = rule(
        1e-9, "the largest eigenvalue of the normal equations", "below, a direction is noise", _IN_USE
    )
    coloured: float = rule(
        2.0, "the standard deviation of white residuals", "neighbouring samples leave alike", _IN_USE
    )
    estimable: float = rule(
        1e-3, "a combination of parameters that the samples leave open", "more is a guess", _IN_USE
    )
    speaks: float = rule(
        0.05,
        "the torques' variance that the file's masses explain beyond all else",
        "with less, they say nothing of the unit",
        _IN_USE,
    )
    heavy: float = rule(
        0.05, "the largest joint's torque (energy) by the file", "a lighter one says little", _IN_USE
    )
    per_parameter: int = rule(10, "equations per parameter", "with fewer, anything fits", _IN_USE)
    room: float = rule(
        3.0, "rad or m", "smaller positions are neither degrees nor millimetres", "no data: what robots do"
    )
    longest_shift: float = rule(0.15, "s of a torque's delay, either way", "more is another log", _IN_USE)
    most_shift: int = rule(60, "samples of the same", "time", _IN_USE)
    sure_delay: float = rule(
        3.0, "standard deviations from which a delay is corrected", "less may be chance", _IN_USE
    )

    def __post_init__(self) -> None:
        shares = ("slow", "stands", "energy", "determined", "estimable", "speaks", "heavy")
        in_range(self, "equation_checks", 0, 1, *shares)


EQUATIONS = EquationCheckRules()
