"""Thresholds of fitting a model that nobody can look into, and of what its residual is said to depend on."""

from dataclasses import dataclass

from pyident.rules.confidence import LEVEL
from pyident.rules.rule import in_range, rule

_DRAWN = "by hand; on the drawn outputs of studies/greybox_thresholds "
_ARITHMETIC = "arithmetic: about a hundred times the square root of what doubles resolve"
_READING = "by hand: it changes what is shown, no finding"


@dataclass(frozen=True)
class GreyboxRules:
    """Slopes that can be trusted, parameters that are seen, and dependences worth a sentence."""

    smooth: float = rule(
        0.05,
        "a slope by which a smaller step's differs",
        "with more, outputs jump with parameters",
        f"{_DRAWN}half or twice changes nothing",
    )
    unseen: float = rule(
        1e-6, "the largest singular value, slopes scaled", "a direction below is arithmetic", _ARITHMETIC
    )
    at_bound: float = rule(1e-6, "a parameter's size, from its bound", "nearer is at it", _ARITHMETIC)
    starts: int = rule(
        16,
        "starts where all bounds are finite",
        "each costs a simulation",
        f"{_DRAWN}20 of 20 frequencies are found (half: 14, twice: 20)",
    )
    level: float = rule(
        LEVEL, "chance of a finding where there is none, over all outputs", "the usual level", "convention"
    )
    shifts: int = rule(
        199,
        "circular shifts, at least",
        "more for many outputs, so that the level is within reach",
        "closed form: the least p-value is 1/(1 + shifts) = 0.5 %, a tenth of the level",
    )
    folds: int = rule(
        4,
        "pieces of a log, each explained by the others",
        "fewer learn by heart",
        f"{_DRAWN}weak friction is named in 14 of 20 (half: 7, twice: 15)",
    )
    material: float = rule(
        0.01,
        "a residual that a dependence takes",
        "less is not worth a sentence",
        f"{_DRAWN}half or twice changes nothing",
    )
    tie: float = rule(
        0.8,
        "best share: what explains as much is named beside it",
        "signals are alike",
        f"{_DRAWN}friction is named in 14 of 20 (half: 0, an order instead)",
    )
    late: float = rule(
        0.5,
        "a residual that a delay takes, the parameters fitted with it",
        "a force that is missing looks late in part",
        "by hand: a true delay of three samples took 99 %, a ripple and a backlash that looked early 20 %",
    )
    constant: float = rule(
        4.0,
        "standard deviations of a mean: a constant beyond is told",
        "chance is below 1e-4 for each output",
        "arithmetic: twice the tail of a normal distribution beyond four deviations is 6e-5",
    )
    worse: float = rule(
        1.05,
        "an output's own scatter that is left: from there on a constant explains more",
        "a fit that does not describe an output has no intervals",
        "by reason: an output of noise alone leaves 1, one in a wrong unit left 1.6",
    )
    begun: float = rule(
        3.0,
        "what is missed of an output later on: as much at the beginning is a start that differs",
        "a motion that a log begins with dies out, which noise does not",
        "by reason: noise leaves about 1",
    )
    away: float = rule(
        1e12,
        "an output's own scatter by which the model misses it, at its start or for a slope",
        "it grows without bound, and squares of its slopes overflow",
        "arithmetic: a trust region cannot come back from there in the rounds that it has",
    )
    tiny: float = rule(
        1e-3,
        "a value that starts at 0, in its unit",
        "steps of differences are larger",
        "arithmetic: that step",
    )
    few: int = rule(
        5,
        "samples per parameter",
        "with fewer, what is left says too little of the noise",
        "arithmetic: Student's t of five per parameter is 1.03 times the normal one",
    )
    rounding: float = rule(
        1e-9,
        "an output's own size that is missed",
        "less is arithmetic",
        "arithmetic: what files and FMUs round",
    )
    shown: int = rule(4, "names of a tie", "more are read by nobody", _READING)
    terms: int = rule(3, "terms of one output", "more are read by nobody", _READING)
    white: float = rule(
        0.01, "p-value of white noise, over all outputs", "what is left below it is none", "convention"
    )
    lags: int = rule(20, "lags of the test for white noise", "convention", "convention")

    def __post_init__(self) -> None:
        in_range(self, "greybox", 0, 1, "smooth", "level", "material", "tie", "late", "white")


GREYBOX = GreyboxRules()
