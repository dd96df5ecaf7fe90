"""How a residual is cut into frequencies, states and stretches of time when a model is compared with logs."""

from dataclasses import dataclass
from math import log

from pyident.rules.rule import RulesError, in_range, rule

_ARMS = "by hand; on the ten arms of studies/compare_thresholds half or twice as much changes no place"
_READING = "by hand: it changes what is shown, no verdict"
_NOISE = "bumps in 20 s of drawn noise below 5, 20, 80 Hz (tests/comparison/test_bumps.py)"


@dataclass(frozen=True)
class BinRules:
    """Bins over frequency and state, and bumps over time; shares are of one."""

    edges: tuple[float, ...] = rule(
        (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0), "Hz, lower edges of the bands", "octaves", "convention"
    )
    top: float = rule(0.4, "the Nyquist frequency", "above, differences and noise are all there is", _ARMS)
    lines: int = rule(
        4,
        "lines of the spectrum in a band",
        "with fewer, its mean is chance: that of 4 scatters by 50 %, of 2 by 71, of 8 by 35",
        "chi-square law",
    )
    quantiles: tuple[float, ...] = rule(
        (0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0),
        "a state's samples below each edge",
        "tails tell most",
        _READING,
    )
    pieces: int = rule(6, "pieces of a log's time", "with more, each has too few samples", _READING)
    least_gain: float = rule(
        0.02, "a frequency's part of the residual that is kept, at least", "none is quite without", _ARMS
    )
    least_spread: float = rule(
        0.02, "the logarithm of a replica's mean square", "few replicas may agree by chance", _ARMS
    )
    least_cutoff: float = rule(
        5.0, "Hz of a shown residual", "a slower one would be smeared over its causes", _READING
    )
    ribbon: float = rule(1.645, "deviations of the replicas, either way", "5 to 95 % of them", "normal law")
    window: float = rule(
        0.25,
        "s over which rms are compared",
        "in less, a bump is a peak",
        f"{_NOISE}: 0.4, 0.5, 0.1 (half: 2.0, 0.4, 0.1; twice: 0.3, 0.6, 0.1)",
    )
    leaves: float = rule(
        1.5,
        "the replicas' rms, of a bump",
        "less is no bump to look at",
        f"{_NOISE}: 0.4, 0.5, 0.1 (half: 11.8, 11.8, 7.5; twice: 0.03, 0.05, 0)",
    )
    valley: float = rule(
        log(2.0), "the energy's logarithm", "a fall to half parts two bumps, less does not", _READING
    )
    most_bumps: int = rule(12, "bumps of a log", "more are read by nobody", _READING)

    def __post_init__(self) -> None:
        in_range(self, "bins", 0, 1, "top", "least_gain", "least_spread")
        if list(self.quantiles) != sorted(self.quantiles) or not all(0 <= x <= 1 for x in self.quantiles):
            raise RulesError("rules: bins.quantiles must rise, with shares between 0 and 1")


BINS = BinRules()
