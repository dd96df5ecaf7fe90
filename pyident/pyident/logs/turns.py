"""Angles that were wrapped to one turn: from one sample to the next they jump by the whole of it."""

import numpy as np

TURNS = {2 * np.pi: "rad", 360.0: "deg"}  # units of a column per turn, and the unit that this is
_NEAR = 0.1  # of a turn: what a jump may be off the whole, and what any other step may be
_RARE = 0.05  # of the steps: jumps beyond are no wraps


def whole_turn(x: np.ndarray) -> float | None:
    """Units of a column (N,) per turn, where it was wrapped to one; None where it was not.

    It stays within a turn, jumps by nearly the whole of it, and but for these jumps is smooth; empty cells do
    not count.
    """
    x = x[~np.isnan(x)]
    if len(x) < 4 or not np.isfinite(x).all():
        return None
    steps = np.abs(np.diff(x))
    for turn in TURNS:
        jumps = steps > turn / 2
        near = np.abs(steps[jumps] - turn) < _NEAR * turn
        smooth = (steps[~jumps] < _NEAR * turn).all()
        if 0 < jumps.sum() <= _RARE * len(steps) and near.all() and smooth and np.ptp(x) < (1 + _NEAR) * turn:
            return turn
    return None


def unwrapped(x: np.ndarray, turn: float | None) -> np.ndarray:
    """A column (N,) without its jumps of whole turns; as it is where `turn`, its units per turn, is None.

    Empty cells stay, and are passed over.
    """
    if turn is None:
        return x
    out, there = np.array(x, float), ~np.isnan(x)
    out[there] = np.unwrap(x[there], period=turn)
    return out
