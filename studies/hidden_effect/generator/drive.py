"""Hidden laws of the motor, its amplifier and what hangs on it: ripple, springs, couplings, payload."""

import casadi as ca
import numpy as np

from flexmodels.coordinate import motor_of

from .law import Constants, Draw, law


@law(
    "torque_ripple",
    lambda d: {
        "first": d.torque(0.15, 0.3),
        "second": d.torque(0.03, 0.1),
        "poles": float(d.rng.integers(4, 20)),
        "phase1": d.phase(),
        "phase2": d.phase(),
    },
)
def _torque_ripple(arm, k, c, _):
    N, e = c["poles"], arm.e(k)
    ripple = c["first"] * ca.cos(N * e + c["phase1"]) + c["second"] * ca.cos(2 * N * e + c["phase2"])
    arm.resist(motor_of(k), ripple)


def _draw_torque_delay(d: Draw) -> Constants:
    """As late as the joint's loop bears: those of joints 1 and 3 of four_link bear next to nothing."""
    latest = {2: 0.8, 4: 1.2}.get(d.k, 0.2)
    return {"samples": min(d.strong(0.6, 1.0, latest), latest)}


@law("torque_delay", _draw_torque_delay, joints=(2, 4))
def _torque_delay(arm, k, c, _):
    """The loop delays the torque; nothing to add to the arm."""


@law(
    "torque_saturation",
    lambda d: {
        "limit": d.between(0.55, 0.75) / d.amplitude * float(d.levels.peak[d.k - 1]),
        "soft": float(d.rng.integers(2)),
    },
)
def _torque_saturation(arm, k, c, _):
    """The loop limits the torque; nothing to add to the arm."""


def _draw_gravity_spring(d: Draw) -> Constants:
    a, b, free, angle = 0.1, d.between(0.2, 0.4), d.between(0.05, 0.1), d.between(-0.3, 0.3)
    turn = np.linspace(0, np.pi / 2) - angle
    distance = np.sqrt(a**2 + b**2 - 2 * a * b * np.cos(turn))
    lever = (distance - free) * a * b * np.sin(turn) / distance
    stiffness = d.torque(0.2, 0.4) / float(np.sqrt(np.mean(lever**2)))
    geometry = {"inner": a, "outer": b, "free": free, "angle": angle}
    return {"stiffness": stiffness, **geometry}


@law("gravity_spring", _draw_gravity_spring, joints=(2, 3))
def _gravity_spring(arm, k, c, _):
    """A spring between a pivot on the base side and one on the link, by their true distance."""
    turn = arm.e(k) + arm.eps(k, 1) - c["angle"]
    a, b = c["inner"], c["outer"]
    distance = ca.sqrt(a**2 + b**2 - 2 * a * b * ca.cos(turn))
    arm.potential(c["stiffness"] * (distance - c["free"]) ** 2 / 2)


@law(
    "joint_spring",
    lambda d: {
        "stiffness": d.torque(0.3, 0.5),
        "cubic": d.torque(0.01, 0.03),
        "centre": d.between(0.2, 1.2),
    },
)
def _joint_spring(arm, k, c, _):
    """Hoses between the links on both sides of the joint."""
    x = arm.e(k) + arm.eps(k, 1) - c["centre"]
    arm.potential(c["stiffness"] * x**2 / 2 + c["cubic"] * x**4 / 4)


@law(
    "joint_coupling",
    lambda d: {
        "coulomb": d.torque(0.08, 0.15),
        "viscous": d.torque(0.05, 0.12),
        "inertia": d.strong(0.1, 0.25, d.value("J_m")),
        "sign": d.sign(),
        "smooth": d.between(0.002, 0.01),
    },
    joints=(1, 2, 3),
)
def _joint_coupling(arm, k, c, numbers):
    """A shaft that turns with both motors: its friction and its inertia."""
    v = arm.de(k) + c["sign"] * arm.de(k + 1)
    torque = c["coulomb"] * ca.tanh(v / c["smooth"]) + c["viscous"] * v
    arm.resist(motor_of(k), torque)
    arm.resist(motor_of(k + 1), c["sign"] * torque)
    arm.inertia({motor_of(k): 1.0, motor_of(k + 1): numbers["sign"]}, c["inertia"])


@law(
    "payload",
    lambda d: {"mass": d.strong(1.5, 3.5, 1), "radius": d.between(0.04, 0.09), "on": 1.0},
    joints=(4,),
)
def _payload(arm, k, c, _):
    """A sphere of steel or less at the tip; `on` is 0 in logs without it."""
    m = c["mass"] * c["on"]
    x, y, z = arm.robot.tip
    ball = 0.4 * m * c["radius"] ** 2
    added = [m, m * x, m * y, m * z]
    added += [m * (y * y + z * z) + ball, -m * x * y, -m * x * z]
    added += [m * (x * x + z * z) + ball, -m * y * z, m * (x * x + y * y) + ball]
    arm.bodies[-1] = [own + more for own, more in zip(arm.bodies[-1], added, strict=True)]
