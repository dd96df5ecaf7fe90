"""Encoders in a log: a channel's step and noise, and twists that are the difference of two channels."""

import numpy as np
import pandas as pd

from flexmodels.coordinate import deformation_of, joint_number, motor_of

_LEAST = 10  # changes
_FEW = 20  # steps of which a change tells one exactly
_NEAR = 0.02  # of a step
_SMALLEST = 100  # changes of a fast motion
_FEWEST = 8.0  # steps that the smallest of them may be
_FINE, _WAVES = 8, 20_000  # waves in the width of a peak, and at most
_IN_PHASE = 0.9
_ALIKE = 0.01  # of a step: encoders of one kind
_STEPS = 100.0  # times the power of rounding: with more, the step is no matter of the noise
_COARSER = 1.5  # times the steps of a twist: those of a link, of which it is no multiple
_ROUNDING = 2.0  # times the same power: with less it is nothing else
_NOISE_FROM = 0.6  # of the Nyquist frequency: above, a motion has little beside its noise
_AGAINST = -0.5  # correlation of the two noises; of equal encoders it is -0.71


def resolution(x: np.ndarray) -> float:
    """The step of a quantised channel x (N,), 0: none. Every change is a multiple of the smallest."""
    changes = np.abs(np.diff(x))
    changes = changes[changes > 1e-12 * max(float(np.abs(x).max()), 1e-300)]
    if len(changes) < _LEAST:
        return 0.0
    slow = float(np.quantile(changes, 0.01))
    few = changes[changes < (_FEW + 0.5) * slow]  # a text's rounding is a part of many steps
    return _exact(few, slow) or _common_divisor(np.sort(changes)[:_SMALLEST])


def noise_of(x: np.ndarray) -> float:
    """Standard deviation of a channel's white noise (x: (N,), in its unit), from its sixth differences."""
    return float(1.4826 * np.median(np.abs(np.diff(x, 6))) / np.sqrt(924))


def _exact(changes: np.ndarray, step: float) -> float:
    """About a step, that of which changes are multiples; 0: they are of none."""
    steps = np.round(changes / step)
    if not (steps > 0).any():
        return 0.0
    step = float(np.median(changes[steps > 0] / steps[steps > 0]))
    ratio = changes / step
    return step if np.mean((ratio > 0.5) & (np.abs(ratio - np.round(ratio)) < _NEAR)) >= 0.95 else 0.0


def _common_divisor(changes: np.ndarray) -> float:
    """The step of which small changes, in order, are multiples where hardly any is of one step.

    Waves of the step's length are in phase at all of them.
    """
    least, most = changes[0], changes[-1]
    first, last, step = 0.98 / least, _FEWEST / least, 1 / (_FINE * most)
    if (last - first) / step > _WAVES:
        return 0.0
    waves = np.arange(first, last, step)
    phases = np.exp(2j * np.pi * np.outer(waves, changes)).mean(axis=1)
    alike = np.flatnonzero(np.abs(phases) > _IN_PHASE)
    if not len(alike):
        return 0.0
    near = waves <= waves[alike[0]] + 2 / most
    return _exact(changes, 1 / float(waves[near][np.argmax(np.abs(phases[near]))]))


def second_encoders(frame: pd.DataFrame) -> dict[str, str]:
    """Twist -> motor position, of joints whose twist is a second encoder's reading less the motor's.

    The twist then holds the noise of both, that of the motor's with the other sign, which a link that is put
    together from the two has lost. They show by the steps of the link, which a twist alone has not; where
    these are those of the twist, too, by noise that goes against each other, of a motor rounded alike,
    or whose noise is nothing else.
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
    if not steps[0]:
        return False
    if resolution(motor + twist) > _COARSER * steps[1]:
        return True  # only a link's encoder makes steps of the two together
    window = np.hanning(len(motor))
    top = [np.fft.rfft((x - x.mean()) * window)[int(_NOISE_FROM * (len(x) // 2)) :] for x in (motor, twist)]
    power = [float(np.mean(np.abs(S) ** 2) / np.sum(window**2)) for S in top]
    alike = abs(steps[1] / steps[0] - 1) <= _ALIKE
    if min(power) <= 0 or power[0] > (_STEPS if alike else _ROUNDING) * steps[0] ** 2 / 12:
        return False  # a motor that shakes alone twists its drive against it, too
    together = float(np.mean(np.real(top[0] * np.conj(top[1]))) / np.sum(window**2))
    return together < _AGAINST * float(np.sqrt(power[0] * power[1]))
