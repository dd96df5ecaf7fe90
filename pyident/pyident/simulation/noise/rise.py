"""How far a torque's noise may rise below the frequencies at which a log shows it."""

import numpy as np


def rise(frequency: np.ndarray | float, continued: np.ndarray | float) -> np.ndarray:
    """Energy over that of noise that goes on level, at frequencies [Hz], as arrays are broadcast.

    continued   Hz: below, noise was not measured
    It rises as 1/f² for two octaves, as behind a low pass, and as 1/f below them, as that of amplifiers does.
    """
    below = np.maximum(continued / np.maximum(frequency, 1e-300), 1.0)
    return np.minimum(below**2, 4 * below)
