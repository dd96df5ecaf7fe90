"""What no replica shows: two correct simulators, or a machine and its model, never agree to the last digit.

Integrators differ, gains and clocks are known to so many digits, and near rest dry friction is a step in no
machine and in no other simulator. In logs without noise a floor made of the model's own replicas alone is so
low that all this reads as something missing. So every replica gets errors of its own:

- its torques and deformations a random one, with the spectrum of the channel and a small share of its size,
- its torques what rounding the sign of the speed over the width of standstill changes: the most that is not
  friction of another law. A width drawn below it would show an eighth of that on average.
"""

from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from flexmodels.coordinate import torque_of
from flexmodels.robot import Robot
from pyident.conditioning.reversals.rest import STANDSTILL
from pyident.conditioning.weak_form import condition
from pyident.logs.log import Log
from pyident.regression.candidate_columns import effect_columns

_SMOOTH = 15  # bins over which a channel's spectrum is averaged


def inexact(robot: Robot, log: Log, share: float, seed: int) -> Log:
    """The log with torques and deformations as another correct machine would show them; robot: fitted.

    share   of their size at every frequency, to which they are exact
    """
    rng = np.random.default_rng([seed, 1])
    frame = log.frame.copy()
    for name in (*robot.torques, *(c.name for c in robot.q if not c.is_motor)):
        frame[name] = frame[name] + _error(frame[name].to_numpy(float), share, rng)
    for name, change in _rounded(robot, log).items():
        frame[name] = frame[name] + change
    return replace(log, frame=frame)


def _error(x: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """(N,): of random phase and the spectrum of x (N,) about its mean."""
    S = np.fft.rfft(x - x.mean())
    power = uniform_filter1d(np.square(np.abs(S)), min(_SMOOTH, len(S)), mode="nearest")
    size = share * np.sqrt(np.maximum(power, 0.0))  # a running sum rounds
    chance = (rng.standard_normal(len(S)) + 1j * rng.standard_normal(len(S))) / np.sqrt(2)
    return np.fft.irfft(size * chance, len(x))


def _rounded(robot: Robot, log: Log) -> dict[str, np.ndarray]:
    """Torque -> (N,), the change by dry friction whose sign is tanh(v / v_rest)."""
    motion = condition(log, robot).motion
    lost = (len(log.frame) - len(motion.q)) // 2
    changes = {}
    for k, joint in robot.numbered:
        speed = np.abs(motion.dq[:, k - 1])
        v_rest = max(STANDSTILL * float(np.sqrt(np.mean(speed**2))), 1e-300)
        dry = np.zeros(len(speed))
        for law in (law for law in joint.effects if law.holds_still):
            for name, by_row in effect_columns(robot, k, law.name, motion).items():
                dry += joint.values[law.name][name] * by_row.get(k - 1, 0.0)
        changes[torque_of(k)] = np.pad(dry * (np.tanh(speed / v_rest) - 1), lost)
    return changes
