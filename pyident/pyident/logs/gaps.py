"""Cells of a column that hold no number where its other rows go on."""

import numpy as np

WIDEST_GAP = 5.5  # periods: over more, nothing is known of a motion


def widest_gap(steps: np.ndarray, period: float) -> int | None:
    """Which of the steps (N,) [any unit] of a time is too wide a gap to be filled, the widest; None: none is.

    period   usual step, in the same unit
    """
    if not len(steps) or not np.nanmax(steps) > WIDEST_GAP * period > 0:
        return None
    return int(np.nanargmax(steps))


def in_short_gaps(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Empty cells (N,) of a column (N,) between filled ones that are no farther apart than rows may be.

    time   (N,) of its rows; where it does not rise throughout, no cell counts
    """
    empty = np.isnan(values)
    filled = np.flatnonzero(~empty)
    found = np.zeros(len(values), bool)
    if not empty.any() or len(filled) < 4 or not np.isfinite(time).all() or (np.diff(time) <= 0).any():
        return found
    wide = np.diff(time[filled]) > WIDEST_GAP * np.median(np.diff(time))
    after = np.searchsorted(filled, np.arange(len(values)))
    inside = empty & (after > 0) & (after < len(filled))
    found[inside] = ~wide[after[inside] - 1]
    return found
