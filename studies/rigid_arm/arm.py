"""A rigid six-axis arm that others simulate: Pinocchio's inverse dynamics along sums of sines.

Geometry and, if not changed, bodies are those of the shipped tx40; no controller is known, and nothing here
knows the project's laws. Torques and encoders are noisy.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from flexmodels.settings.processing import Processing
from pyident.logs.log import Log

from .pinocchio_chain import chain, inverse_dynamics

RATE = 100.0  # Hz
COULOMB = np.array([8.0, 9.0, 6.0, 2.5, 3.0, 2.0])
VISCOUS = np.array([9.0, 7.0, 4.0, 1.5, 2.0, 0.8])
ROTOR = np.array([0.35, 0.4, 0.1, 0.04, 0.06, 0.02])  # kg m²
REACH = np.array([1.2, 0.8, 0.9, 1.5, 1.2, 1.8])
TORQUE_NOISE, ENCODER_NOISE = 0.004, 2e-6  # of the joint's rms torque; rad


@dataclass(frozen=True)
class Motion:
    """time (N,); q, v, a, load (N, 6) [rad, rad/s, rad/s², N m]: load is what the links ask for."""

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    load: np.ndarray


def arm() -> Robot:
    """The robot file: rigid, without controller, with the friction that every robot file has."""
    robot = load_robot("tx40")
    basic = ("motor_inertia", "coulomb", "viscous", "offset")
    joints = tuple(
        replace(j, values={law: v for law, v in j.values.items() if law in basic}) for j in robot.joints
    )
    plain = replace(robot, joints=joints, transmission=None, controller=None)
    return plain.with_settings(columns={}, processing=Processing())


def moved(
    robot: Robot, rng: np.random.Generator, duration: float, pace: float = 1.0, rate: float = RATE
) -> Motion:
    """`duration` [s] along sums of six sines a joint, drawn, sampled at a rate [Hz]; needs the package `pin`.

    pace   frequencies of the sines over those of a slow motion
    """
    time = np.arange(0, duration, 1 / rate)
    q, v, a = (np.zeros((len(time), 6)) for _ in range(3))
    for k in range(6):
        for harmonic in range(1, 7):
            omega = pace * 2 * np.pi * 0.06 * harmonic * (1 + 0.05 * rng.random())
            size, phase = REACH[k] * rng.uniform(0.2, 0.6) / harmonic, rng.uniform(0, 2 * np.pi)
            q[:, k] += size * np.sin(omega * time + phase)
            v[:, k] += size * omega * np.cos(omega * time + phase)
            a[:, k] -= size * omega**2 * np.sin(omega * time + phase)
    return Motion(time, q, v, a, inverse_dynamics(chain(robot), q, v, a))


def torque_noise(tau: np.ndarray) -> np.ndarray:
    """Standard deviations (6,) [N m] that go with torques (N, 6)."""
    return TORQUE_NOISE * np.sqrt(np.mean(tau**2, axis=0))


def recorded(
    motion: Motion, tau: np.ndarray, noise: np.ndarray, rng: np.random.Generator, source: str
) -> Log:
    """The log that the arm's sensors leave: `noise` (6,) on the torques (N, 6), ENCODER_NOISE on q."""
    tau = tau + noise * rng.standard_normal(tau.shape)
    q = motion.q + ENCODER_NOISE * rng.standard_normal(motion.q.shape)
    columns = {"time": motion.time}
    columns |= {f"joint{k + 1}.e": q[:, k] for k in range(6)}
    columns |= {f"joint{k + 1}.tau": tau[:, k] for k in range(6)}
    return Log(pd.DataFrame(columns), source)
