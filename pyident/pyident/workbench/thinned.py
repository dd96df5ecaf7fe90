"""Long traces thinned to what a screen can show, peaks kept."""

import numpy as np

POINTS = 1_200  # of a trace on the page


def thinned(time: np.ndarray, values: np.ndarray, points: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Time (N,) and a trace (N,) as at most `points` samples, extremes of every stretch among them."""
    from tsdownsample import MinMaxLTTBDownsampler

    if len(values) <= points:
        return time, values
    at = MinMaxLTTBDownsampler().downsample(time, np.ascontiguousarray(values, dtype=float), n_out=points)
    return time[at], values[at]


def thinned_band(
    time: np.ndarray, low: np.ndarray, high: np.ndarray, points: int = POINTS
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time and a ribbon's edges, (points,) each: per stretch the least of `low`, the greatest of `high`."""
    if len(time) <= points:
        return time, low, high
    starts = np.linspace(0, len(time), points, endpoint=False).astype(int)
    return time[starts], np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)


def window(time: np.ndarray, span: tuple[float, float] | None) -> slice:
    """The samples within a time span [s]; all of them without one."""
    if span is None:
        return slice(0, len(time))
    first, last = np.searchsorted(time, span)
    return slice(max(int(first) - 1, 0), int(last) + 1)
