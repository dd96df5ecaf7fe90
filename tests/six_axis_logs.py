"""Logs of a rigid six-axis arm from another simulator: Pinocchio's inverse dynamics, friction of its own.

The loop is not in the robot file, torques are noisy, encoders too, and nothing here knows the project's laws.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
from pinocchio_model import PinocchioRobot

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from flexmodels.settings.processing import Processing
from pyident.logs.log import Log

RATE, DURATION = 100.0, 30.0  # Hz, s
COULOMB = np.array([8.0, 9.0, 6.0, 2.5, 3.0, 2.0])
VISCOUS = np.array([9.0, 7.0, 4.0, 1.5, 2.0, 0.8])
ROTOR = np.array([0.35, 0.4, 0.1, 0.04, 0.06, 0.02])  # kg m²
REACH = np.array([1.2, 0.8, 0.9, 1.5, 1.2, 1.8])
TORQUE_NOISE, ENCODER_NOISE = 0.004, 2e-6  # of the joint's rms torque; rad

Friction = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def arm() -> Robot:
    """A rigid arm without controller, with the friction that every robot file has."""
    robot = load_robot("tx40")
    basic = ("motor_inertia", "coulomb", "viscous", "offset")
    joints = tuple(
        replace(j, values={law: v for law, v in j.values.items() if law in basic}) for j in robot.joints
    )
    return replace(
        robot, joints=joints, transmission=None, columns={}, controller=None, processing=Processing()
    )


def plain(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Coulomb and viscous friction, (N, 6)."""
    return COULOMB * np.sign(v) + VISCOUS * v


def made(
    robot: Robot, seed: int, friction: Friction = plain, duration: float = DURATION, pace: float = 1.0
) -> Log:
    """One log along sums of sines of its own; pace: their frequencies over those of a slow motion."""
    rng = np.random.default_rng(seed)
    oracle = PinocchioRobot(robot)
    time = np.arange(0, duration, 1 / RATE)
    q, v, a = (np.zeros((len(time), 6)) for _ in range(3))
    for k in range(6):
        for harmonic in range(1, 7):
            omega = pace * 2 * np.pi * 0.06 * harmonic * (1 + 0.05 * rng.random())
            size, phase = REACH[k] * rng.uniform(0.2, 0.6) / harmonic, rng.uniform(0, 2 * np.pi)
            q[:, k] += size * np.sin(omega * time + phase)
            v[:, k] += size * omega * np.cos(omega * time + phase)
            a[:, k] -= size * omega**2 * np.sin(omega * time + phase)
    load = np.array([oracle.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])
    tau = load + ROTOR * a + friction(q, v, load, time)
    tau = tau + TORQUE_NOISE * np.sqrt(np.mean(tau**2, axis=0)) * rng.standard_normal(tau.shape)
    q = q + ENCODER_NOISE * rng.standard_normal(q.shape)
    columns = {"time": time}
    columns |= {f"joint{k + 1}.e": q[:, k] for k in range(6)}
    columns |= {f"joint{k + 1}.tau": tau[:, k] for k in range(6)}
    return Log(pd.DataFrame(columns), f"log {seed}")


def three_laws(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Load-dependent friction at joints 2 and 3, sub-linear viscous friction at joint 1."""
    out = plain(q, v, load, time)
    out[:, 1:3] += 0.12 * np.abs(load[:, 1:3]) * np.sign(v[:, 1:3])
    out[:, 0] += 9.0 * (np.sign(v[:, 0]) * np.abs(v[:, 0]) ** 0.5 - v[:, 0])
    return out
