"""Periodic references that set out from home, and begin and end at rest by construction.

A joint's share of the period is a Fourier series whose coefficients lie in the null space of three linear
conditions: no speed, no acceleration and no jerk at the period's ends. Before it a polynomial of fifth degree
takes the joint from home to where the period begins. Every shape is scaled to what the limits of position,
speed and acceleration allow, so that any vector of numbers is a motion that keeps them.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import null_space

from flexmodels.experiment import line_profile
from flexmodels.robot import RobotError
from pyident.excitation.limits import Limits

_PEAK_SPEED, _PEAK_ACCELERATION = 15 / 8, 10 / np.sqrt(3)  # of the polynomial, per way and time


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

    def __post_init__(self) -> None:
        if self.approach > self.duration / 2:
            raise RobotError(
                f"a motion of {self.duration:g} s is too short: the limits let the robot reach its range "
                f"only in {self.approach:.3g} s; give at least {2 * self.approach:.3g} s"
            )

    @property
    def joints(self) -> int:
        return len(self.limits.speed)

    @property
    def size(self) -> int:
        return self.joints * (self._null.shape[1] + 2)

    @cached_property
    def approach(self) -> float:
        """Time of the way from home [s], enough for the longest one."""
        x = self.limits
        way = np.maximum(x.upper - x.home, x.home - x.lower)
        by_speed = _PEAK_SPEED * way / x.speed
        by_acceleration = np.sqrt(_PEAK_ACCELERATION * way / x.acceleration)
        return float(np.maximum(by_speed, by_acceleration).max())

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
        time = np.arange(round(self.duration / step) + 1) * step
        begins = time < self.approach
        inside = time[~begins] - self.approach
        parts = np.asarray(x, float).reshape(self.joints, -1)
        q, dq, ddq = np.zeros((3, len(time), self.joints))
        for k, numbers in enumerate(parts):
            series = self._series(inside) @ (self._null @ numbers[:-2])
            whole = self._series(np.linspace(0, self.period, 201)) @ (self._null @ numbers[:-2])
            centre, swing, middle = self._fitted(k, whole, *numbers[-2:])
            q[~begins, k] = centre + swing * (series[0] - middle)
            dq[~begins, k], ddq[~begins, k] = swing * series[1], swing * series[2]
            first = centre + swing * (whole[0, 0] - middle)
            q[begins, k], dq[begins, k], ddq[begins, k] = self._approached(k, first, time[begins])
        home = self.limits.home
        return Reference(time, home + scale * (q - home), scale * dq, scale * ddq)

    def _series(self, time: np.ndarray) -> np.ndarray:
        """(3, N, 2 harmonics): sines and cosines with their first and second derivatives."""
        rate = 2 * np.pi * np.arange(1, self.harmonics + 1) / self.period
        s, c = np.sin(np.outer(time, rate)), np.cos(np.outer(time, rate))
        return np.array(
            [np.hstack([s, c]), np.hstack([c * rate, -s * rate]), -np.hstack([s, c]) * np.tile(rate, 2) ** 2]
        )

    def _fitted(self, k: int, whole: np.ndarray, pose: float, use: float) -> tuple[float, float, float]:
        """Centre, factor and middle of a shape (3, N) that uses a share of what joint k may do."""
        x = self.limits
        middle, half = (whole[0].max() + whole[0].min()) / 2, np.ptp(whole[0]) / 2
        share = 1 / (1 + np.exp(-2.5 - use))
        swing = share * min(
            (x.upper[k] - x.lower[k]) / 2 / max(half, 1e-12),
            x.speed[k] / max(np.abs(whole[1]).max(), 1e-12),
            x.acceleration[k] / max(np.abs(whole[2]).max(), 1e-12),
        )
        room = (x.upper[k] - x.lower[k]) / 2 - swing * half
        return (x.upper[k] + x.lower[k]) / 2 + room * np.tanh(pose), swing, middle

    def _approached(self, k: int, first: float, time: np.ndarray) -> tuple[np.ndarray, ...]:
        home, T = self.limits.home[k], self.approach
        s = time / T
        way = first - home
        speed = way / T * (30 * s**2 - 60 * s**3 + 30 * s**4)
        return home + way * line_profile(s), speed, way / T**2 * (60 * s - 180 * s**2 + 120 * s**3)
