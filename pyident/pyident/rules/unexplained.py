"""Thresholds of what an unexplained residual is said to depend on, and of what `add` accepts."""

from dataclasses import dataclass

from pyident.rules.rule import in_range, rule

_FORCES = "by hand; of six hidden forces (tests/diagnosis/test_unexplained.py) "
_READING = "by hand: it changes how much is said and how long it takes, no verdict"


@dataclass(frozen=True)
class UnexplainedRules:
    """Terms of a residual that no law explains."""

    equations: int = rule(2, "equations that are looked at", "the worst ones; time", _READING)
    equation: float = rule(
        0.2, "excess that an equation still has to be looked at", "the worst ones; time", _READING
    )
    terms: int = rule(3, "terms of one equation", "more are read by nobody", _READING)
    tie: float = rule(
        0.95,
        "best gain: who explains as much is named as well",
        "splines are alike",
        f"{_FORCES}half gives one a false rival",
    )
    material: float = rule(
        0.03,
        "excess that a term takes",
        "less is not worth a sentence",
        f"{_FORCES}twice loses a wave of 5 % under another force",
    )
    sure: float = rule(6.0, "standard deviations of a chi-square", "many terms are tried", "chi-square law")
    beyond: float = rule(
        3.0,
        "the most that a replica pretends",
        "few replicas are made",
        f"{_FORCES}half or twice changes none",
    )
    stretch: float = rule(
        0.1, "time of all logs that one stretch takes at most", "a longer one is no event", _READING
    )
    stretch_share: float = rule(
        0.6, "excess that lies in one stretch", "with less, the rest matters as much", _READING
    )
    level: float = rule(0.01, "p-value of a peak, corrected for the spectrum", "convention", "convention")

    def __post_init__(self) -> None:
        in_range(
            self, "unexplained", 0, 1, "equation", "tie", "material", "level", "stretch", "stretch_share"
        )


@dataclass(frozen=True)
class ExtensionRules:
    """What `add` accepts."""

    fitted: float = rule(2 / 3, "an only log that is fitted", "the rest judges", "convention")
    least_gain: float = rule(
        0.05,
        "mean square error on held-out data that a law takes away",
        "less is no reason for a law",
        "by hand; half or twice changes no answer on eight arms of studies/thresholds",
    )

    def __post_init__(self) -> None:
        in_range(self, "extension", 0.1, 0.9, "fitted")
        in_range(self, "extension", 0.0, 1.0, "least_gain")
