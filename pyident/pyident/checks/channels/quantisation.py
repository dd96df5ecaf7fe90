"""Where a channel repeats its value, and the step in which it comes: too coarse for accelerations?"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot
from pyident.checks.defect import Defect
from pyident.conditioning.smooth_motion import all_reached
from pyident.conditioning.weak_form import DERIVATIVES
from pyident.logs.encoders import noise_of
from pyident.logs.log import Log
from pyident.rules.channel_checks import CHANNELS
from pyident.rules.log_checks import LOG_CHECKS


@dataclass(frozen=True)
class Runs:
    """First sample and number of samples of every run of equal values."""

    start: np.ndarray
    length: np.ndarray


def runs(x: np.ndarray) -> Runs:
    """Of equal values one after the other in x (N,)."""
    start = np.concatenate([[0], np.flatnonzero(np.diff(x)) + 1])
    return Runs(start, np.diff(np.append(start, len(x))))


def coarse(robot: Robot, log: Log, name: str, x: np.ndarray) -> Iterator[Defect]:
    """Rounding of x (N,) that makes a good part of the acceleration, without noise that would smooth it.

    Where neither a filter nor a controller is given, frequencies count by their noise: those of the motion.
    """
    step = step_of(x)
    if step == 0 or noise_of(x) > step or np.ptp(x) < CHANNELS.standing * step:
        return
    from scipy.signal import butter, sosfiltfilt  # here: much memory, for few logs

    plan, T = robot.settings.processing, log.period
    nyquist = 0.5 / T
    reached = all_reached(x[:, None])[0] if plan.cutoff is None and robot.controller is None else 1.0
    top = min(plan.cutoff or nyquist * reached, 0.8 * nyquist / plan.decimate)
    share = (2 * np.pi) ** 2 * np.sqrt(top**5 / 5 / nyquist)  # rms acceleration per rms of white noise
    smooth = sosfiltfilt(np.asarray(butter(4, top / nyquist, output="sos")), x[:, None], axis=0)
    _, _, dde = DERIVATIVES["central"](np.asarray(smooth), T)
    acceleration = float(np.sqrt(np.mean(dde[20:-20] ** 2)))
    rounding = step / np.sqrt(12) * share
    if rounding > LOG_CHECKS.coarse * acceleration:
        percent = 100 * min(rounding / max(acceleration, 1e-300), 1)
        yield Defect("doubtful", "coarse", name, f"{log.source}: {name} comes in steps of {step:.3g}, which "
                                                 "make "
                     f"some {percent:.0f} % of its acceleration; lower processing.cutoff in the robot file "
                     f"or record with a finer resolution")  # fmt: skip


def step_of(x: np.ndarray) -> float:
    """The step in which a channel x (N,) is quantised, in its unit; 0: none."""
    values = np.unique(x)
    if len(values) < 3:
        return 0.0
    gaps = np.diff(values)
    tiny = 1e-9 * float(np.abs(values).max())
    real = np.sort(gaps[gaps > tiny])
    if not len(real):
        return 0.0
    step = float(np.median(real[: max(3, len(real) // 100)]))
    off = np.abs(gaps / step - np.round(gaps / step))
    return step if np.mean(off < 0.05) > 0.95 and np.median(np.round(gaps / step)) < 50 else 0.0
