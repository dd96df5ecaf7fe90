"""A servo that lifts a pendulum, and its loop written again; SciPy or Euler integrates between samples."""

from dataclasses import replace

import numpy as np
from one_joint import one_joint
from scipy.integrate import solve_ivp

from flexmodels.inputs import Experiment
from flexmodels.link import Link
from flexmodels.robot import Robot
from flexmodels.settings.servo import Servo

MASS, ARM, WEIGHT, ARMATURE = 0.5, 0.1, 0.5 * 9.81 * 0.1, 0.002
RATE, KT, R, SUPPLY, SATURATION = 1000.0, 0.35, 4.0, 7.4, 0.2


def pendulum() -> Robot:
    """Hangs at e = 0 from a horizontal axis, without friction."""
    base = one_joint()
    joint = replace(
        base.joints[0],
        x=(0.0, 1.0, 0.0),
        y=(0.0, 0.0, 1.0),
        values={"motor_inertia": {"J_m": ARMATURE}, "viscous": {"viscous": 0.001}},
    )
    link = Link(MASS, (0.0, 0.0, -MASS * ARM), (MASS * ARM**2, 0.0, 0.0, MASS * ARM**2, 0.0, 0.0))
    servo = Servo(
        rate=RATE, supply=SUPPLY, kp=(300.0,), gain=(0.003,), kt=(KT,), R=(R,), ki=(150.0,), kd=(2.0,),
        limit=(0.8,), dead_band=(0.01,), saturation=(SATURATION,), delay=0.0125,
    )  # fmt: skip
    return replace(base, name="pendulum", joints=(joint,), links=(link,), controller=None, servo=servo)


def by_hand(
    plan: Experiment, armature: float = ARMATURE, kt: float = KT, viscous: float = 0.001
) -> np.ndarray:
    """The loop of flexmodels.settings.servo, written from its description; SciPy between its samples."""
    ticks = np.arange(round(plan.time[-1] * RATE) + 1) / RATE
    late = np.interp(ticks - 0.0125, plan.time, plan.reference[:, 0])
    on = np.interp(ticks, plan.time, plan.on[:, 0]) >= 0.5  # pyright: ignore[reportOptionalSubscript]
    e, de, integral, track = 0.2, 0.0, 0.0, [0.2]
    for i in range(len(ticks) - 1):
        torque = 0.0
        if on[i]:
            error = late[i] - e if abs(late[i] - e) >= 0.01 else 0.0
            integral += error / RATE if i else 0.0
            duty = np.clip(0.003 * (300 * error + 150 * integral - 2 * de), -0.8, 0.8)
            current = (SUPPLY * duty - kt * de) / R
            torque = kt * current / (1 + SATURATION * abs(current))
        else:
            integral = 0.0

        def rate(_, x, torque=torque):
            force = torque - WEIGHT * np.sin(x[0]) - viscous * x[1]
            return [x[1], force / (MASS * ARM**2 + armature)]

        e, de = solve_ivp(rate, (0, 1 / RATE), [e, de], rtol=1e-9, atol=1e-11).y[:, -1]
        track.append(e)
    return np.interp(plan.time, ticks, track)


def guessed() -> Robot:
    """A pendulum with friction, whose robot file guesses the torque constant and the delay."""
    robot = pendulum()
    assert robot.servo is not None
    servo = replace(
        robot.servo, kp=(400.0,), ki=(0.0,), kd=(0.0,), limit=(1.0,), dead_band=(0.0,), saturation=(0.0,),
        delay=0.002, kt=(0.45,), unknown=("kt", "delay"),
    )  # fmt: skip
    values = {"motor_inertia": {"J_m": 0.001}, "coulomb": {"coulomb": 0.01}, "viscous": {"viscous": 0.005}}
    return replace(robot, joints=(replace(robot.joints[0], values=values),), servo=servo)


def stepped(
    reference: np.ndarray, load: float = 0.0, spring: float = 0.0, delay: int = 6, switched_off: int = 10**9
) -> np.ndarray:
    """(N,) positions of that robot at 1 kHz, by Euler's method; kt 0.35, delay [ms], Coulomb friction that
    grows with the weight by `load`, a spring [N m/rad], an encoder of 4096 counts, off from [ms] on."""
    count, dt, inertia = 2 * np.pi / 4096, 1e-4, MASS * ARM**2 + ARMATURE
    e, de, measured, track = float(reference[0]), 0.0, 0.0, []
    for i in range(len(reference)):
        measured = count * round(e / count)
        track.append(measured)
        duty = np.clip(0.003 * 400 * (reference[max(i - delay, 0)] - measured), -1.0, 1.0)
        for _ in range(10):
            torque = KT * (SUPPLY * duty - KT * de) / R if i < switched_off else 0.0
            weight = -WEIGHT * np.sin(e) - spring * e
            hold = 0.03 + load * abs(weight)
            free = torque + weight - 0.01 * de
            after = de + dt * (free - hold * np.sign(de if de else free)) / inertia
            de = 0.0 if de * after < 0 or (de == 0 and abs(free) < hold) else float(after)
            e += dt * de
    return np.array(track)
