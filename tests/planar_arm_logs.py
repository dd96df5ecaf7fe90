"""Logs of a vertical three-joint arm from another simulator: Pinocchio, RK4, friction that is round at rest.

Three joints about a horizontal axis, in a loop of their own at 250 Hz with the noise of the encoders in it; a
multisine is fed forward and not logged;
the torque's sensor has white noise. Parameters are 10 to 25 % off the robot file.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pinocchio as pin

from flexmodels.files.robot_file import load_robot
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot
from flexmodels.settings.controller import Controller
from flexmodels.settings.processing import Processing
from pyident.logs.log import Log

RATE, STEPS = 250.0, 16  # Hz; of the integration per sample
ROUND = 0.004  # rad/s over which friction changes its sign
ENCODER_NOISE, TORQUE_NOISE = 2e-6, 0.002  # rad; of the largest torque
LENGTHS = (0.0, 0.42, 0.36)  # m, from the joint before
COULOMB, VISCOUS, ROTOR = np.array([7.0, 5.0, 1.2]), np.array([5.0, 3.0, 0.4]), np.array([0.9, 0.5, 0.06])
MASSES, COMS = (9.0, 6.0, 1.6), (0.2, 0.17, 0.06)


def planar_arm() -> Robot:
    """Joints about −y, links along x in the zero pose; nominal values."""
    joints, links = [], []
    for k in range(3):
        values = {
            "motor_inertia": {"J_m": float(ROTOR[k])},
            "coulomb": {"coulomb": float(COULOMB[k])},
            "viscous": {"viscous": float(VISCOUS[k])},
        }
        origin = (LENGTHS[k], 0.0, 0.0)
        joints.append(
            Joint(
                kind="revolute",
                x=(0.0, -1.0, 0.0),
                y=(1.0, 0.0, 0.0),
                origin=origin,
                flexible=False,
                values=values,
            )
        )
        J = MASSES[k] * COMS[k] ** 2 / 3
        links.append(Link.of_centre(MASSES[k], np.array([COMS[k], 0, 0]), np.diag([J / 10, J, J])))
    loop = Controller(RATE, (5200.0, 2600.0, 160.0), (260.0, 130.0, 8.0), (9000.0, 4500.0, 300.0))
    return replace(
        load_robot("four_link"),
        name="planar_arm",
        joints=tuple(joints),
        links=tuple(links),
        tip=(0.12, 0.0, 0.0),
        controller=loop,
        processing=Processing(),
        identification=None,
        line=None,
    )


def made(seed: int, seconds: float = 10.0, off: int = 5, longer: float = 0.0) -> Log:
    """One log; `off` draws the true parameters, so logs of one arm share it.

    longer   by which joint 3 is farther from joint 2 than the robot file says [m]
    """
    robot, truth = planar_arm(), np.random.default_rng(off)
    sizes = 1 + truth.choice([-1.0, 1.0], (4, 3)) * truth.uniform(0.1, 0.25, (4, 3))
    model, data = _arm(sizes[0], longer)
    coulomb, viscous, rotor = sizes[1] * COULOMB, sizes[2] * VISCOUS, sizes[3] * ROTOR
    model.armature = rotor
    rng = np.random.default_rng(seed)
    N, T = round(seconds * RATE), 1 / RATE
    time = np.arange(N) * T
    reference = _reference(time, rng)
    fed = np.array([16.0, 9.0, 1.1]) * _multisine(time, rng)
    noise = ENCODER_NOISE * rng.standard_normal((N, 3))
    q, v = reference[0].copy(), np.zeros(3)
    integral, before = pin.rnea(model, data, q, v, 0 * v), reference[0] - q - noise[0]
    assert robot.controller is not None
    Kp, Kd, Ki = (np.array(g) for g in (robot.controller.Kp, robot.controller.Kd, robot.controller.Ki))
    e, tau = np.zeros((N, 3)), np.zeros((N, 3))

    def rate(q, v, torque):
        return pin.aba(model, data, q, v, torque - coulomb * np.tanh(v / ROUND) - viscous * v)

    for n in range(N):
        e[n] = q + noise[n]
        error = reference[n] - e[n]
        if n:
            integral = integral + Ki * T * error
        tau[n] = Kp * error + Kd * (error - before) / T + integral + fed[n]
        before = error
        for _ in range(STEPS):
            q, v = _runge_kutta(q, v, tau[n], T / STEPS, rate)
    logged = tau + TORQUE_NOISE * np.abs(tau).max(axis=0) * rng.standard_normal(tau.shape)
    columns = {"time": time} | {f"joint{k + 1}.e": e[:, k] for k in range(3)}
    columns |= {f"joint{k + 1}.tau": logged[:, k] for k in range(3)}
    columns |= {f"joint{k + 1}.r": reference[:, k] for k in range(3)}
    return Log(pd.DataFrame(columns), f"planar {seed}")


def _arm(sizes: np.ndarray, longer: float):
    model, parent = pin.Model(), 0
    model.gravity.linear = np.array([0, 0, -9.81])
    for k in range(3):
        place = pin.SE3(np.eye(3), np.array([LENGTHS[k] + longer * (k == 2), 0, 0]))
        parent = model.addJoint(
            parent, pin.JointModelRevoluteUnaligned(np.array([0.0, -1, 0])), place, f"j{k}"
        )
        m, com = sizes[k] * MASSES[k], np.array([COMS[k], 0, 0.01])
        J = m * COMS[k] ** 2 / 3
        model.appendBodyToJoint(parent, pin.Inertia(m, com, np.diag([J / 10, J, J])), pin.SE3.Identity())
    return model, model.createData()


def _runge_kutta(q, v, torque, h, rate):
    a1 = rate(q, v, torque)
    a2 = rate(q + h / 2 * v, v + h / 2 * a1, torque)
    a3 = rate(q + h / 2 * (v + h / 2 * a1), v + h / 2 * a2, torque)
    a4 = rate(q + h * (v + h / 2 * a2), v + h * a3, torque)
    return q + h * v + h * h / 6 * (a1 + a2 + a3), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


def _reference(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    swing = rng.uniform(0.4, 0.9, 3) * rng.choice([-1, 1], 3)
    period = rng.uniform(2.0, 5.0, 3)
    return np.array([0.4, -0.6, 0.5]) + swing * (1 - np.cos(2 * np.pi * time[:, None] / period)) / 2


def _multisine(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Of unit rms, 0.5 to 40 Hz."""
    lines = np.linspace(0.5, 40, 80)
    waves = np.cos(2 * np.pi * time[:, None, None] * lines + rng.uniform(0, 2 * np.pi, (3, 80))).sum(axis=2)
    return waves / np.sqrt(40)
