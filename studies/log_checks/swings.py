"""Logs of rigid arms made by Pinocchio: inverse dynamics along a motion, with friction and sensors."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from flexmodels.settings.processing import Processing

from ..rigid_arm.pinocchio_chain import chain, inverse_dynamics, pinocchio

_FRICTION = (0.06, 0.03)  # of the joint's rms torque: Coulomb, and viscous at its rms speed
_MOTORS = 0.15  # of the mean of a joint's mass matrix element


@dataclass(frozen=True)
class Motion:
    """Swings of every joint: rms speed [rad/s or m/s], highest frequency [Hz], duration and period [s]."""

    speed: float = 0.6
    highest: float = 0.8
    duration: float = 12.0
    period: float = 0.004
    standing: tuple[int, ...] = ()
    rest: float = 0.0  # [s] at the start
    in_turn: bool = False


def six_axes() -> Robot:
    """The shipped TX40 without its gears, as a controller at 250 Hz would log it."""
    robot = load_robot("tx40")
    plain = replace(robot.without_effect("joint_coupling"), name="six_axes", transmission=None)
    return plain.with_settings(processing=Processing(cutoff=40.0))


def recorded(robot: Robot, motion: Motion, seed: int, noise: float = 2e-6) -> pd.DataFrame:
    """A log of the arm, its masses up to 20 % off the file's; needs the package `pin`.

    noise   [rad or m] of the encoders; torques have 0.5 % of their rms
    """
    rng = np.random.default_rng(seed)
    q, dq, ddq, time = _swings(robot, motion, rng)
    model = chain(robot, rng.uniform(0.8, 1.2, len(robot.links)))
    tau, data = inverse_dynamics(model, q, dq, ddq), model.createData()
    M = np.mean([np.diag(pinocchio().crba(model, data, row)) for row in q[:: max(1, len(q) // 20)]], axis=0)
    tau += _MOTORS * M * ddq
    level, speed = tau.std(axis=0) + 1e-3 * np.abs(tau).max(), dq.std(axis=0) + 1e-9
    tau += level * (_FRICTION[0] * np.tanh(dq / 1e-3) + _FRICTION[1] * dq / speed)
    frame = {"time": time}
    for k in range(q.shape[1]):
        frame[f"joint{k + 1}.e"] = q[:, k] + rng.normal(0, noise, len(q))
        frame[f"joint{k + 1}.tau"] = tau[:, k] + rng.normal(0, 5e-3 * level[k], len(q))
    return pd.DataFrame(frame)


def _swings(robot: Robot, motion: Motion, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """q, dq, ddq (N, joints) and time: five sines a joint, faded in smoothly after the rest."""
    time = np.arange(round(motion.duration / motion.period)) * motion.period
    n = len(robot.joints)
    q, dq, ddq = (np.zeros((len(time), n)) for _ in range(3))
    for k, joint in enumerate(robot.joints):
        if k + 1 in motion.standing:
            continue
        w = 2 * np.pi * np.sort(rng.uniform(0.08, motion.highest, 5))
        a, phase = rng.uniform(0.5, 1, 5), rng.uniform(0, 2 * np.pi, 5)
        wave = [(a * w**i * np.cos(np.outer(time, w) + phase + i * np.pi / 2)).sum(axis=1) for i in range(3)]
        size = motion.speed * (0.3 if joint.kind == "prismatic" else 1.0) / wave[1].std()
        start, stop = motion.rest, motion.duration
        if motion.in_turn:
            start, stop = (motion.duration * (k + i) / n for i in (0, 1))
        f = _faded(time, start, stop, 0.2 * (stop - start), motion.in_turn)
        x, dx, ddx = (size * v for v in wave)
        q[:, k], dq[:, k] = f[0] * x, f[0] * dx + f[1] * x
        ddq[:, k] = f[0] * ddx + 2 * f[1] * dx + f[2] * x
    return q, dq, ddq, time


def _faded(time: np.ndarray, start: float, stop: float, over: float, out: bool) -> list[np.ndarray]:
    """A factor from 0 to 1 (and back) without a jump in its second derivative, and its two derivatives."""

    def rise(t: np.ndarray) -> list[np.ndarray]:
        s = np.clip(t / over, 0, 1)
        return [s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2 / over,
                60 * s * (1 - s) * (1 - 2 * s) / over**2]  # fmt: skip

    up = rise(time - start)
    if not out:
        return up
    down = rise(stop - time)
    return [up[0] * down[0], up[1] * down[0] - up[0] * down[1],
            up[2] * down[0] - 2 * up[1] * down[1] + up[0] * down[2]]  # fmt: skip
