"""Logs of the rigid six-axis arm of the study, with frictions of the tests' own."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from studies.rigid_arm.arm import (
    COULOMB,
    ROTOR,
    VISCOUS,
    arm,
    moved,
    recorded,
    torque_noise,
)

from flexmodels.robot import Robot
from pyident.logs.log import Log

pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")

__all__ = ["COULOMB", "ROTOR", "arm", "late", "made", "plain", "three_laws"]

DURATION = 30.0  # s

Friction = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def plain(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Coulomb and viscous friction, (N, 6)."""
    return COULOMB * np.sign(v) + VISCOUS * v


def made(
    robot: Robot, seed: int, friction: Friction = plain, duration: float = DURATION, pace: float = 1.0
) -> Log:
    """One log along sums of sines of its own; pace: their frequencies over those of a slow motion."""
    rng = np.random.default_rng(seed)
    motion = moved(robot, rng, duration, pace)
    tau = motion.load + ROTOR * motion.a + friction(motion.q, motion.v, motion.load, motion.time)
    return recorded(motion, tau, torque_noise(tau), rng, f"log {seed}")


def three_laws(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Load-dependent friction at joints 2 and 3, sub-linear viscous friction at joint 1."""
    out = plain(q, v, load, time)
    out[:, 1:3] += 0.12 * np.abs(load[:, 1:3]) * np.sign(v[:, 1:3])
    out[:, 0] += 9.0 * (np.sign(v[:, 0]) * np.abs(v[:, 0]) ** 0.5 - v[:, 0])
    return out


def late(log: Log, samples: float) -> Log:
    """The log with all positions late, without its ends, at which nothing tells them."""
    time = log.frame["time"].to_numpy()
    names = [name for name in log.frame if name.endswith(".e")]
    moved = {n: CubicSpline(time, log.frame[n])(time - samples * log.period) for n in names}
    return replace(log, frame=log.frame.assign(**moved).iloc[5:-5].reset_index(drop=True))
