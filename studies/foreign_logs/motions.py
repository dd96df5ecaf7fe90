"""Motions of a machine: sums of sines, repeated or never repeating."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np


class Course(Protocol):
    """Any motion of n joints."""

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, speed, acceleration (N, n) at times (N,) [s]."""
        ...


@dataclass(frozen=True)
class Plan:
    """Position of joint k: sum over h of size[k, h] sin(omega[k, h] t + phase[k, h]), arrays (n, H)."""

    size: np.ndarray
    omega: np.ndarray
    phase: np.ndarray

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, speed, acceleration (N, n) at times (N,) [s]."""
        angle = time[:, None, None] * self.omega + self.phase
        return (
            (self.size * np.sin(angle)).sum(axis=2),
            (self.size * self.omega * np.cos(angle)).sum(axis=2),
            -(self.size * self.omega**2 * np.sin(angle)).sum(axis=2),
        )


def drawn_plan(
    rng: np.random.Generator, sliders: np.ndarray, duration: float, periodic: bool, slow: bool
) -> Plan:
    """Five sines a joint; `sliders` (n,) reach 0.3 m at most, hinges 1.5 rad."""
    n, H = len(sliders), 5
    if periodic:
        base = np.full((n, H), 2 * np.pi / (duration / max(1, round(duration / 10))))
        omega = base * np.array([rng.choice(np.arange(1, 11), H, replace=False) for _ in range(n)])
    else:
        omega = 2 * np.pi * rng.uniform(0.07, 1.0, (n, H))
    if slow:
        omega = omega * 0.25
    size = rng.uniform(0.3, 1, (n, H)) / np.maximum(omega / 2, 1)
    size *= (np.where(sliders, 0.3, 1.5) * rng.uniform(0.6, 1, n) / size.sum(axis=1))[:, None]
    return Plan(size, omega, rng.uniform(0, 2 * np.pi, (n, H)))
