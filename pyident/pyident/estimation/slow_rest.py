"""Whether what an estimate leaves of a torque is slow: white noise leaves as much at every frequency.

An interval knows the noise that a residual shows. What is missing is correlated with the motion and bends the
parameters beyond any interval; it is slow like the motion, so a slow rest deserves a word.
"""

from collections.abc import Sequence

import numpy as np

from flexmodels.coordinate import joint_name

SLOW, FAST = 0.5, 2.0  # Hz: below the one are gravity, friction and springs, above the other mostly noise
_LINES = 4  # of the spectrum that are slow: the mean of fewer is chance
_OF_MEDIAN = np.log(2.0)  # a spectral line's median over its mean, by the chi-square law
_TIMES = 3.0  # amplitudes: of white noise never, by that law


def slow_rest(residuals: Sequence[np.ndarray], periods: Sequence[float]) -> tuple[str, ...]:
    """A sentence about joints of whose torques what is left is slow.

    residuals   per log (N, joints), 0 where a sample is not used;  periods: of their samples [s]
    """
    ratios = np.array([_slow_over_fast(r, period) for r, period in zip(residuals, periods, strict=True)])
    worst = ratios.max(axis=0)
    named = [f"{worst[k]:.2g} times at {joint_name(k + 1)}" for k in np.flatnonzero(worst > _TIMES).tolist()]
    if not named:
        return ()
    return (
        f"what is left of the torques is slow: below {SLOW:g} Hz it is {', '.join(named)} what it is above "
        f"{FAST:g} Hz. Slow noise does that, or an effect that is missing, which bends values beyond their "
        "intervals: `pyident diagnose` asks",
    )


def _slow_over_fast(residual: np.ndarray, period: float) -> np.ndarray:
    """(joints,) of a residual (N, joints)."""
    tapered = residual * np.hanning(len(residual))[:, None]
    power = np.square(np.abs(np.fft.rfft(tapered, axis=0)))
    return slow_over_fast(power, np.fft.rfftfreq(len(residual), period))


def slow_over_fast(power: np.ndarray, frequencies: np.ndarray) -> np.ndarray:
    """(joints,) amplitude of the slow part over that of the fast one; 0 where a log is too short to tell.

    power   (lines, joints) at frequencies (lines,) [Hz]
    """
    slow, fast = frequencies < SLOW, frequencies > FAST
    if min(slow.sum(), fast.sum()) < _LINES:
        return np.zeros(power.shape[1])
    level = np.median(power[fast], axis=0) / _OF_MEDIAN
    return np.sqrt(power[slow].mean(axis=0) / np.where(level > 0, level, np.inf))
