"""Periodic references that set out from home, and begin and end at rest by construction.

A joint's share of the period is a Fourier series whose coefficients lie in the null space of three linear
conditions: no speed, no acceleration and no jerk at the period's ends. Before it a polynomial of fifth degree
takes the joint from home to where the period begins; a slow joint stays near home. Every shape is scaled to
what the limits of position, speed and acceleration allow: any vector of numbers is a motion that keeps them.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import null_space

from flexmodels.experiment import line_profile
from pyident.excitation.limits import Limits

_PEAK_SPEED, _PEAK_ACCELERATION = 15 / 8, 10 / np.sqrt(3)  # of the polynomial, per way and time
_LONGEST = 0.4  # of a motion, that its way from home takes at most


@dataclass(frozen=True)
class Reference:
    """time (N,) [s]; q, dq, ddq (N, joints)."""

    time: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray


@dataclass(frozen=True)
class Family:
    """Every reference of a duration [s] under limits, `harmonics` per joint, `repeats` periods.

    A reference is given by `size` numbers of about unit size: per joint the coefficients, the pose about
    which it swings and how much of what is allowed it uses.
    """

    limits: Limits
    duration: float
    harmonics: int
    repeats: int = 1

    @property
    def joints(self) -> int:
        return len(self.limits.speed)

    @property
    def size(self) -> int:
        return self.joints * (self._null.shape[1] + 2)

    @cached_property
    def approach(self) -> float:
        """Time of the way from home [s], enough for the longest one, or as long as the motion lets it be."""
        x = self.limits
        way = np.maximum(x.upper - x.home, x.home - x.lower)
        by_speed = _PEAK_SPEED * way / x.speed
        by_acceleration = np.sqrt(_PEAK_ACCELERATION * way / x.acceleration)
        return min(float(np.maximum(by_speed, by_acceleration).max()), _LONGEST * self.duration)

    @cached_property
    def room(self) -> tuple[np.ndarray, np.ndarray]:
        """(joints,) lowest and highest positions that are within the limits and reached in that time."""
        x, T = self.limits, self.approach
        way = np.minimum(x.speed * T / _PEAK_SPEED, x.acceleration * T**2 / _PEAK_ACCELERATION)
        return np.maximum(x.lower, x.home - way), np.minimum(x.upper, x.home + way)

    @cached_property
    def period(self) -> float:
        return (self.duration - self.approach) / self.repeats

    @cached_property
    def _null(self) -> np.ndarray:
        """(2 harmonics, free) coefficients of sines and cosines under which the ends are at rest."""
        if self.harmonics < 2:
            raise ValueError("a reference at rest at its ends needs two harmonics or more")
        number = np.arange(1, self.harmonics + 1)
        zero = np.zeros(self.harmonics)
        conditions = [
            np.concatenate([number, zero]),
            np.concatenate([zero, number**2]),
            np.concatenate([number**3, zero]),
        ]
        scale = np.tile(1.0 / number, 2)  # high harmonics are fast: unit numbers should be alike in effect
        return scale[:, None] * null_space(np.array(conditions) * scale)

    def reference(self, x: np.ndarray, step: float, scale: float = 1.0) -> Reference:
        """The motion of x (size,) every `step` [s]; scale: of the whole way from home."""
        return self.motion(scale * self.coefficients(x), step)

    def coefficients(self, x: np.ndarray) -> np.ndarray:
        """(joints, 1 + free): where every joint's series is zero, from home, and the series, of x (size,)."""
        parts = np.asarray(x, float).reshape(self.joints, -1)
        shape = self._series(np.linspace(0, self.period, 201)) @ self._null
        out = []
        for k, numbers in enumerate(parts):
            centre, swing, middle = self._fitted(k, shape @ numbers[:-2], *numbers[-2:])
            out.append([centre - swing * middle - self.limits.home[k], *swing * numbers[:-2]])
        return np.array(out)

    def motion(self, coefficients: np.ndarray, step: float) -> Reference:
        """Of coefficients (joints, 1 + free), which may break limits, every `step` [s]."""
        time = self.times(step)
        q, dq, ddq = self.basis(time) @ coefficients.T
        return Reference(time, self.limits.home + q, dq, ddq)

    def times(self, step: float) -> np.ndarray:
        """(N,) every `step` [s]."""
        return np.arange(round(self.duration / step) + 1) * step

    def basis(self, time: np.ndarray) -> np.ndarray:
        """(3, N, 1 + free): position from home, speed and acceleration per unit of a joint's coefficients."""
        begins = time < self.approach
        out = np.zeros((3, len(time), 1 + self._null.shape[1]))
        out[0, ~begins, 0] = 1.0
        out[:, ~begins, 1:] = self._series(time[~begins] - self.approach) @ self._null
        first = np.append(1.0, self._series(np.zeros(1))[0, 0] @ self._null)
        out[:, begins] = _approach(time[begins], self.approach)[:, :, None] * first
        return out

    def _series(self, time: np.ndarray) -> np.ndarray:
        """(3, N, 2 harmonics): sines and cosines with their first and second derivatives."""
        rate = 2 * np.pi * np.arange(1, self.harmonics + 1) / self.period
        s, c = np.sin(np.outer(time, rate)), np.cos(np.outer(time, rate))
        return np.array(
            [np.hstack([s, c]), np.hstack([c * rate, -s * rate]), -np.hstack([s, c]) * np.tile(rate, 2) ** 2]
        )

    def _fitted(self, k: int, whole: np.ndarray, pose: float, use: float) -> tuple[float, float, float]:
        """Centre, factor and middle of a shape (3, N) that uses a share of what joint k may do."""
        x, (lower, upper) = self.limits, (side[k] for side in self.room)
        middle, half = (whole[0].max() + whole[0].min()) / 2, np.ptp(whole[0]) / 2
        share = 1 / (1 + np.exp(-2.5 - use))
        swing = share * min(
            (upper - lower) / 2 / max(half, 1e-12),
            x.speed[k] / max(np.abs(whole[1]).max(), 1e-12),
            x.acceleration[k] / max(np.abs(whole[2]).max(), 1e-12),
        )
        room = (upper - lower) / 2 - swing * half
        return (upper + lower) / 2 + room * np.tanh(pose), swing, middle


def _approach(time: np.ndarray, T: float) -> np.ndarray:
    """(3, N): the share of a way that is gone at times [s] of T, with its derivatives."""
    s = time / T
    return np.array(
        [line_profile(s), (30 * s**2 - 60 * s**3 + 30 * s**4) / T, (60 * s - 180 * s**2 + 120 * s**3) / T**2]
    )
