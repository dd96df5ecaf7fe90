"""Low-pass filters without phase shift, and thinning out."""

import numpy as np

_FORGOTTEN = 1e-15  # share of a filter's start


def thin(columns: np.ndarray, factor: int) -> np.ndarray:
    """Low-pass (N, ...) and keep every `factor`-th sample, along the first axis and without phase shift."""
    if factor == 1:
        return columns
    return without_phase(thinning_filter(factor), columns)[::factor]


def thinning_filter(factor: int) -> np.ndarray:
    """Second-order sections (S, 6) of the low-pass before thinning."""
    from scipy.signal import cheby1  # here and below: much memory, for few robots

    return np.asarray(cheby1(8, 0.05, 0.8 / factor, output="sos"))


def settling(sections: np.ndarray) -> int:
    """Samples after which a filter of second-order sections (S, 6) has forgotten its start to rounding."""
    slowest = max(np.abs(np.roots(section[3:])).max() for section in sections)
    return int(np.ceil(np.log(_FORGOTTEN) / np.log(slowest)))


def without_phase(sections: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Columns (N, ...) filtered there and back along the first axis by sections (S, 6)."""
    from scipy.signal import sosfiltfilt

    return sosfiltfilt(sections, columns, axis=0)
