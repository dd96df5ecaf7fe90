"""Thresholds of a comparison: which part of a residual is worth a sentence."""

from dataclasses import dataclass

from pyident.rules.rule import in_range, rule

_ARMS = "by hand; on the ten arms of studies/compare_thresholds half or twice as much changes no place"
_NOISE = "40 parts drawn from chi-square law, data and replicas alike (tests/comparison/test_chance.py)"


@dataclass(frozen=True)
class ComparisonRules:
    """Where a model fails."""

    replicas: int = rule(
        6,
        "replicas of a comparison",
        "their spread per bin leans on all bins",
        f"{_NOISE}: noise stands out in 3 % (half as many: 2, twice: 1)",
    )
    certain: float = rule(
        1.25,
        "deviations, in those of a replica among the others",
        "what is less a replica shows as well",
        f"{_NOISE}: noise stands out in 3 % (half: 68, twice: 0)",
    )
    matters: float = rule(1.25, "rms residual over its floor", "less is not worth a sentence", _ARMS)
    carries: float = rule(
        0.1, "an equation's excess that the named part holds", "a smaller part explains nothing", _ARMS
    )
    samples: float = rule(0.02, "the samples that the named part holds", "fewer are an accident", _ARMS)
    of_signal: float = rule(
        5e-4, "an equation's signal that its excess reaches", "less is arithmetic and sampling", _ARMS
    )

    def __post_init__(self) -> None:
        in_range(self, "comparison", 3, 10_000, "replicas")
        in_range(self, "comparison", 0, 1, "carries", "samples", "of_signal")
