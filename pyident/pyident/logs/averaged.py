"""Logs of more samples a second than a judgement needs, each of several samples' mean.

A mean over rows is the same filter for positions and torques, without phase about its middle, and half as
long as a row of what is left on either side: an equation that holds at every sample holds for the means as
far as the motion is slow beside them.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.signal import welch

from pyident.logs.log import Log

_ENOUGH = 1000.0  # Hz
_OFTEN_ENOUGH = 500.0  # Hz, where torques hold nothing but noise above what is then judged
_JUDGED = 0.3  # of a rate: equations of rigid joints are sound that far
_SEGMENT = 1024  # samples of a spectrum; of them as many are averaged as there are
_BANDS = 12  # in which a spectrum is asked, from a third of the lowest that is lost to the highest
_HUMP = 1.5  # times the least power below a band: noise falls or stays


def averaged(logs: Sequence[Log]) -> tuple[tuple[Log, ...], tuple[str, ...]]:
    """Logs of twice as many samples a second as are enough, or more, thinned out; and a note on that."""
    each = [_count(log, _ENOUGH) for log in logs]
    fewer = [_count(log, _OFTEN_ENOUGH) for log in logs]
    if not any(_tells_more(log, n) for log, n in zip(logs, fewer, strict=True) if n > 1):
        each = fewer
    thinned = tuple(_mean(log, n) if n > 1 else log for log, n in zip(logs, each, strict=True))
    rates = {(round(1 / log.period), n) for log, n in zip(logs, each, strict=True) if n > 1}
    return thinned, tuple(
        f"{rate} samples a second are more than is needed: judged are the means of {n} each"
        for rate, n in sorted(rates)
    )


def _count(log: Log, rate: float) -> int:
    """Samples of which a mean leaves a rate or more."""
    return max(int(1 / (log.period * rate) + 1e-6), 1)


def _tells_more(log: Log, count: int) -> bool:
    """Whether a torque holds more than noise above what is judged of the means of so many: a ripple, say."""
    lost, highest = _JUDGED / (count * log.period), 0.45 / log.period
    edges = np.geomspace(lost / 3, highest, _BANDS + 1)
    for name in log.frame:
        if str(name).endswith(".tau"):
            x = log.frame[name].to_numpy(float)
            f, S = welch(x, 1 / log.period, nperseg=min(_SEGMENT, len(x)))
            power = np.array([S[(f >= low) & (f < high)].mean() for low, high in pairwise(edges)])
            below = np.minimum.accumulate(power)[:-1]
            if (power[1:] > _HUMP * below)[edges[1:-1] >= lost].any():
                return True
    return False


def _mean(log: Log, count: int) -> Log:
    """Of every `count` rows; a switch is on where it is on in all of them."""
    rows = len(log) // count * count
    groups = log.frame.iloc[:rows].groupby(np.arange(rows) // count)
    frame, least = groups.mean(), groups.min()
    switches = [name for name in frame if str(name).endswith(".on")]
    frame[switches] = least[switches]
    return replace(log, frame=frame.reset_index(drop=True))
