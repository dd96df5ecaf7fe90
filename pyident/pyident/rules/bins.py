"""How a residual is cut into frequencies, states and stretches of time when a model is compared with logs."""

from dataclasses import dataclass
from math import log

from pyident.rules.rule import in_range, rule

_SHIPPED = "not recorded"


@dataclass(frozen=True)
class BinRules:
    """Bins over frequency and state, and bumps over time; shares are of one."""

    edges: tuple[float, ...] = rule(
        (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0), "Hz, lower edges of the bands", "octaves", "convention"
    )
    top: float = rule(0.4, "the Nyquist frequency", "above, differences and noise are all there is", _SHIPPED)
    lines: int = rule(4, "lines of the spectrum in a band", "with fewer, its mean is chance", _SHIPPED)
    quantiles: tuple[float, ...] = rule(
        (0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0),
        "a state's samples below each edge",
        "tails tell most",
        _SHIPPED,
    )
    pieces: int = rule(6, "pieces of a log's time", "with more, each has too few samples", _SHIPPED)
    least_gain: float = rule(
        0.02, "a frequency's part of the residual that is kept, at least", "none is quite without", _SHIPPED
    )
    least_spread: float = rule(
        0.02, "the logarithm of a replica's mean square", "few replicas may agree by chance", _SHIPPED
    )
    least_cutoff: float = rule(
        5.0, "Hz of a shown residual", "a slower one would be smeared over its causes", _SHIPPED
    )
    ribbon: tuple[float, float] = rule((5.0, 95.0), "percentiles of the replicas", "convention", "convention")
    window: float = rule(0.25, "s over which rms are compared", "in less, a bump is a peak", _SHIPPED)
    leaves: float = rule(1.5, "the replicas' rms, of a bump", "less is no bump to look at", _SHIPPED)
    valley: float = rule(
        log(2.0), "the energy's logarithm", "a fall to half parts two bumps, less does not", _SHIPPED
    )
    most_bumps: int = rule(12, "bumps of a log", "more are read by nobody", _SHIPPED)

    def __post_init__(self) -> None:
        in_range(self, "bins", 0, 1, "top", "least_gain", "least_spread")


BINS = BinRules()
