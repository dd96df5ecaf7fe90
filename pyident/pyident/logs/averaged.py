"""Logs of more samples a second than a judgement needs, each of several samples' mean.

A mean over rows is the same filter for positions and torques, without phase about its middle, and half as
long as a row of what is left on either side: an equation that holds at every sample holds for the means as
far as the motion is slow beside them.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyident.logs.log import Log

_ENOUGH = 1000.0  # Hz


def averaged(logs: Sequence[Log]) -> tuple[tuple[Log, ...], tuple[str, ...]]:
    """Logs of twice as many samples a second as are enough, or more, thinned out; and a note on that."""
    each = [max(int(1 / (log.period * _ENOUGH) + 1e-6), 1) for log in logs]
    thinned = tuple(_mean(log, n) if n > 1 else log for log, n in zip(logs, each, strict=True))
    rates = {(round(1 / log.period), n) for log, n in zip(logs, each, strict=True) if n > 1}
    return thinned, tuple(
        f"{rate} samples a second are more than is needed: judged are the means of {n} each"
        for rate, n in sorted(rates)
    )


def _mean(log: Log, count: int) -> Log:
    """Of every `count` rows; a switch is on where it is on in all of them."""
    rows = len(log) // count * count
    groups = log.frame.iloc[:rows].groupby(np.arange(rows) // count)
    frame, least = groups.mean(), groups.min()
    switches = [name for name in frame if str(name).endswith(".on")]
    frame[switches] = least[switches]
    return replace(log, frame=frame.reset_index(drop=True))
