"""A log of one rigid joint from its closed form: no FMU, no integrator."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
from one_joint import one_joint

from flexmodels.robot import Robot
from pyident.logs.log import Log

INERTIA, VISCOUS, COULOMB = 1.1, 2.0, 1.0  # kg m² of motor and link, N m s/rad, N m
_TONES = ((0.8, 0.31, 0.2), (0.35, 0.83, 1.4), (0.2, 1.7, 2.3))  # amplitude [rad], frequency [Hz], phase


def free_joint() -> Robot:
    """`one_joint` without its controller: torques are not held."""
    return replace(one_joint(), controller=None)


def analytic_log(
    seconds: float = 20.0, period: float = 0.004, angle_noise: float = 0.0, torque_noise: float = 0.0, seed=0
) -> Log:
    """The joint follows a few sines; its torque is that of the equation of motion."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds / period)) * period
    q, dq, ddq = np.zeros((3, len(t)))
    for amplitude, f, phase in _TONES:
        w = 2 * np.pi * f
        q += amplitude * np.sin(w * t + phase)
        dq += amplitude * w * np.cos(w * t + phase)
        ddq -= amplitude * w**2 * np.sin(w * t + phase)
    tau = INERTIA * ddq + VISCOUS * dq + COULOMB * np.sign(dq)
    frame = {
        "time": t,
        "joint1.e": q + angle_noise * rng.standard_normal(len(t)),
        "joint1.tau": tau + torque_noise * rng.standard_normal(len(t)),
    }
    return Log(pd.DataFrame(frame), "closed form")


def logs_with(torque: Callable[..., np.ndarray]) -> list[Log]:
    """Three logs in whose noise [N m] a further torque f(q, v, load) lies; load: what moves the link."""
    return [_with(torque, analytic_log(seconds=16.0 + n, torque_noise=0.02, seed=n)) for n in range(3)]


def _with(torque: Callable[..., np.ndarray], log: Log) -> Log:
    q, tau, t = (log.frame[name].to_numpy() for name in ("joint1.e", "joint1.tau", "time"))
    v = np.gradient(q, t)
    load = tau - VISCOUS * v - COULOMB * np.sign(v)
    return replace(log, frame=log.frame.assign(**{"joint1.tau": tau + torque(q, v, load)}))
