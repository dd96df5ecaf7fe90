"""Encoders in a log: the step in which a channel comes, and twists that are the difference of two of them."""

import numpy as np
import pandas as pd

from flexmodels.coordinate import deformation_of, joint_number, motor_of

_ALIKE = 0.01  # of a step: encoders of one kind
_STEPS = 100.0  # times the power of rounding: with more, the step is no matter of the noise
_NOISE_FROM = 0.6  # of the Nyquist frequency: above, a motion has little beside its noise
_AGAINST = -0.5  # correlation of the two noises; of equal encoders it is -0.71


def resolution(x: np.ndarray) -> float:
    """The step of a quantised channel x (N,), 0: none. Every change is a multiple of the smallest."""
    changes = np.abs(np.diff(x))
    changes = changes[changes > 1e-12 * max(float(np.abs(x).max()), 1e-300)]
    if len(changes) < 10:
        return 0.0
    step = float(np.quantile(changes, 0.01))
    ratio = changes / step
    steps = np.round(ratio)
    if np.mean((steps > 0) & (np.abs(ratio - steps) < 0.02)) < 0.95:
        return 0.0
    return float(np.median(changes[steps > 0] / steps[steps > 0]))


def second_encoders(frame: pd.DataFrame) -> dict[str, str]:
    """Twist -> motor position, of joints whose twist is a second encoder's reading less the motor's.

    The twist then holds the noise of both, that of the motor's with the other sign, which a link that is put
    together from the two has lost. They show by their common step, and by noise that goes against each other.
    """
    found = {}
    for name in frame:
        joint = joint_number(name) if str(name).endswith(".eps[1]") else 0
        if joint and (motor := motor_of(joint)) in frame:
            pair = frame[motor].to_numpy(float), frame[deformation_of(joint)].to_numpy(float)
            if _differ_in_noise(*pair):
                found[deformation_of(joint)] = motor
    return found


def _differ_in_noise(motor: np.ndarray, twist: np.ndarray) -> bool:
    steps = resolution(motor), resolution(twist)
    if not all(steps) or abs(steps[1] / steps[0] - 1) > _ALIKE:
        return False
    window = np.hanning(len(motor))
    top = [np.fft.rfft((x - x.mean()) * window)[int(_NOISE_FROM * (len(x) // 2)) :] for x in (motor, twist)]
    power = [float(np.mean(np.abs(S) ** 2) / np.sum(window**2)) for S in top]
    if min(power) <= 0 or power[0] > _STEPS * steps[0] ** 2 / 12:
        return False
    together = float(np.mean(np.real(top[0] * np.conj(top[1]))) / np.sum(window**2))
    return together < _AGAINST * float(np.sqrt(power[0] * power[1]))
