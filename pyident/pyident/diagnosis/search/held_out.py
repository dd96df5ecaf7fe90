"""What candidates, fitted to some logs, take away of the residual in others."""

from collections.abc import Sequence

import numpy as np

from pyident.diagnosis.base.candidates import Candidate, columns
from pyident.diagnosis.base.residual_over_floor import whitened
from pyident.diagnosis.search.search import Search
from pyident.logs.log import Log
from pyident.regression.spectrum import Equations


def whitened_heldout(search: Search, heldout: Sequence[Log]) -> list[Equations]:
    """The equations of logs that were not used, over the floor of those that were. Raises LogError."""
    ex = search.examination
    return whitened(ex.setting.robot, heldout, ex.floor)


def heldout_gain(search: Search, chosen: Sequence[Candidate], held: Sequence[Equations]) -> float:
    """Share of the residual's energy in held-out logs that these candidates, fitted to the others, take."""
    return 1 - left_over(search, chosen, held) / left_over(search, (), held)


def left_over(search: Search, chosen: Sequence[Candidate], held: Sequence[Equations]) -> float:
    """Energy of the residual on held-out logs, with everything fitted to the others."""
    p, x = search.fitted(chosen)
    return sum(_left_of(search, log, p, x, chosen) for log in held)


def _left_of(
    search: Search, log: Equations, p: np.ndarray, x: np.ndarray, acting: Sequence[Candidate]
) -> float:
    """Of one log; a payload is there or not, whichever fits."""
    residual = log.y - log.A @ p
    at = 0
    for candidate in acting:
        everywhere = Candidate(candidate.effect, candidate.joint, candidate.values)
        X = columns(search.robot, everywhere, [log], [np.ones_like(log.y)])[0]
        width = next(iter(X.values())).shape[1]
        level = search.examination.floor.at(log.band)
        more = residual.copy()
        for c, values in X.items():
            more[c] -= values @ x[at : at + width] / level[c]
        if candidate.log is None or np.square(more).sum() < np.square(residual).sum():
            residual = more
        at += width
    return float(np.square(residual).sum())
