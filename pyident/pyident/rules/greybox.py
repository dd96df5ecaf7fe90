"""Thresholds of fitting a model that nobody can look into, and of what its residual is said to depend on."""

from dataclasses import dataclass

from pyident.rules.confidence import LEVEL
from pyident.rules.rule import in_range, rule

_WRITTEN = "not recorded"


@dataclass(frozen=True)
class GreyboxRules:
    """Slopes that can be trusted, parameters that are seen, and dependences worth a sentence."""

    smooth: float = rule(
        0.05, "a slope by which a smaller step's differs", "with more, outputs jump with parameters", _WRITTEN
    )
    unseen: float = rule(
        1e-6, "the largest singular value, slopes scaled", "a direction below is arithmetic", _WRITTEN
    )
    at_bound: float = rule(1e-6, "a parameter's size, from its bound", "nearer is at it", _WRITTEN)
    starts: int = rule(16, "starts where all bounds are finite", "each costs a simulation", _WRITTEN)
    level: float = rule(
        LEVEL, "chance of a finding where there is none, over all outputs", "the usual level", "convention"
    )
    shifts: int = rule(
        199, "circular shifts, at least", "more for many outputs, so that the level is within reach", _WRITTEN
    )
    folds: int = rule(4, "pieces of a log, each explained by the others", "fewer learn by heart", _WRITTEN)
    material: float = rule(
        0.01, "a residual that a dependence takes", "less is not worth a sentence", _WRITTEN
    )
    tie: float = rule(
        0.8, "best share: what explains as much is named beside it", "signals are alike", _WRITTEN
    )
    shown: int = rule(4, "names of a tie", "more are read by nobody", _WRITTEN)
    terms: int = rule(3, "terms of one output", "more are read by nobody", _WRITTEN)
    lags: int = rule(20, "lags of the test for white noise", "convention", "convention")

    def __post_init__(self) -> None:
        in_range(self, "greybox", 0, 1, "smooth", "level", "material", "tie")


GREYBOX = GreyboxRules()
