"""A mask that fades in and out.

Noise of second differences cancels in sums with what is smooth, and would not at a hard edge.
"""

from dataclasses import replace

import numpy as np

from pyident.conditioning.samples import Conditioned

_FADE = 6  # samples over which the mask fades


def fading(use: np.ndarray, fade: int = _FADE) -> np.ndarray:
    """(N, n) a mask of 0 and 1 that falls smoothly to 0 before it is 0, and at both ends."""
    window = np.hanning(2 * fade + 1)
    window /= window.sum()
    n = len(use)
    padded = np.pad(use.astype(float), ((2 * fade, 2 * fade), (0, 0)))
    free = np.lib.stride_tricks.sliding_window_view(padded, 2 * fade + 1, axis=0).min(axis=-1)
    free = np.lib.stride_tricks.sliding_window_view(free, 2 * fade + 1, axis=0)
    return (free @ window)[:n]


def faded(part: Conditioned) -> Conditioned:
    """Equations that fade in and out where their friction is not known."""
    return replace(part, use=fading(part.use))
