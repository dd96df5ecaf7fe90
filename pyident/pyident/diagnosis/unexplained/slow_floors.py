"""Where what is left of a torque is slow, though it exceeds no floor: the floor has it for noise.

Along a measured motion a floor has the noise that the residual shows, whatever made it. Slow noise fills it
as an effect does that is missing, and that no law of the catalogue is like, such as a body that slides.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from flexmodels.coordinate import joint_number
from pyident.diagnosis.result import Place
from pyident.diagnosis.search.search import Search
from pyident.estimation.slow_rest import FAST, SLOW, slow_over_fast

_TIMES = 5.0  # amplitudes: torques of drives that lack nothing have three


def slow_floors(beside: Search, places: Sequence[Place]) -> dict[str, float]:
    """Joint -> amplitude below SLOW over that above FAST, of motor sides that are in order.

    beside   rests on what was named;  places: that are asked about
    """
    ex, found = beside.examination, {}
    for place in places:
        if place.balance != "motor" or place.state != "in_order":
            continue
        row, ratios = joint_number(place.joint) - 1, []
        for log, left, level in zip(ex.logs, beside.base.residual, ex.levels, strict=True):
            lines = np.square(left[row] * level[row]).reshape(2, -1).sum(axis=0)
            ratios.append(float(slow_over_fast(lines[:, None], log.band.frequencies)[0]))
        if max(ratios) > _TIMES:
            found[place.joint] = max(ratios)
    return found


def of_slow_floors(found: Mapping[str, float]) -> Iterator[str]:
    """What that means for a verdict. found: as of `slow_floors`."""
    named = [f"{ratio:.2g} times at {joint}" for joint, ratio in found.items()]
    if named:
        yield (
            f"what is left of the torques is slow: below {SLOW:g} Hz it is {', '.join(named)} what it is "
            f"above {FAST:g} Hz. Slow noise does that, or something that is missing and that no law of the "
            "catalogue is like: the floor has it for noise, and hides what is as slow; a motion that repeats "
            "would tell"
        )
