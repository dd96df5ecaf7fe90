"""Parameter sets to run: one row per set, one column per parameter.

`ranges` gives every parameter's lowest and highest value; samples are uniform between them.
"""

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
import pandas as pd

Ranges = Mapping[str, tuple[float, float]]


def grid(values: Mapping[str, Sequence[float]]) -> pd.DataFrame:
    """Every combination of the values; the last parameter changes fastest."""
    return pd.DataFrame(list(product(*values.values())), columns=list(values), dtype=float)


def latin_hypercube(ranges: Ranges, runs: int, seed: int = 0) -> pd.DataFrame:
    """`runs` sets; every parameter has one value in each of `runs` equal intervals."""
    from scipy.stats import qmc

    return _scaled(qmc.LatinHypercube(len(ranges), rng=np.random.default_rng(seed)).random(runs), ranges)


def sobol(ranges: Ranges, runs: int, seed: int = 0) -> pd.DataFrame:
    """A scrambled Sobol sequence of at least `runs` sets: the next power of two, which keeps its balance."""
    from scipy.stats import qmc

    power = max(0, int(np.ceil(np.log2(runs))))
    points = qmc.Sobol(len(ranges), rng=np.random.default_rng(seed)).random_base2(power)
    return _scaled(points, ranges)


def _scaled(points: np.ndarray, ranges: Ranges) -> pd.DataFrame:
    """points (N, parameters) in [0, 1)."""
    low, high = np.array(list(ranges.values()), dtype=float).T
    return pd.DataFrame(low + points * (high - low), columns=list(ranges))
