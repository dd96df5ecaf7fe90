"""What a parameter study's table says: spread of the results, failures, sensitivities."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from pyident.sweep.sampling import Ranges
from pyident.sweep.sensitivity import Method, sensitivity

_OF_THE_RUN = ("seconds", "failure")


def result_names(table: pd.DataFrame, parameters: Iterable[str]) -> list[str]:
    """Columns that are results."""
    beside = {*parameters, *_OF_THE_RUN}
    return [str(name) for name in table if name not in beside]


def summary(table: pd.DataFrame, parameters: Iterable[str]) -> pd.DataFrame:
    """Smallest, median and largest value of every result."""
    results = table[result_names(table, parameters)].astype(float)
    return results.quantile([0.0, 0.5, 1.0]).T.set_axis(["smallest", "median", "largest"], axis=1)


def failures(table: pd.DataFrame) -> list[str]:
    """A sentence per reason, the most frequent first."""
    counts = table.loc[table["failure"] != "", "failure"].value_counts()
    return [f"{count} of {len(table)} runs failed: {reason}" for reason, count in counts.items()]


def sensitivities(method: Method, ranges: Ranges, table: pd.DataFrame) -> pd.DataFrame:
    """Index (result, parameter); columns of `sensitivity`. Raises StudyError."""
    names = result_names(table, ranges)
    each = [sensitivity(method, ranges, table, np.asarray(table[name], dtype=float)) for name in names]
    return pd.concat(each, keys=names, names=["result", "parameter"])
