"""Replicas: logs as the fitted model would have made them, over the same motion with the same sensor noise.

What the identical analysis finds in a replica is not physics but the method's own trace. Where the log holds
references and the robot file its controller, the replica is the same closed loop; else it tracks the measured
motion under a stabilising controller with the measured torque fed forward.
"""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from scipy.fft import rfft

from flexmodels.coordinate import feedforward_of, motor_of, reference_of, torque_of
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from flexmodels.settings.controller import Controller
from pyident.logs.log import Log
from pyident.regression.regressor import Motion, regressor

OpenWorkers = Callable[[Robot], AbstractContextManager[Any]]  # processes that hold a robot's FMU
Run = Callable[[Experiment, Mapping[str, float]], pd.DataFrame]

_NOISE_BAND = 0.8  # of the Nyquist frequency: above, a log that differs from its simulation differs by noise
_BANDWIDTH = 10.0  # Hz of the stand-in controller
_MEDIAN = np.log(2)  # of a periodogram's ordinate, per its mean


@dataclass(frozen=True)
class Repeat:
    """How a log can be made again: `plan` for the closed loop, `log` for what it must look like."""

    log: Log
    plan: Experiment

    def replica(
        self, run: Run, parameters: Mapping[str, float], noise: Mapping[str, float], seed: int
    ) -> Log:
        """The log's motion made by a model; noise: coordinate -> standard deviation of its sensor."""
        rng = np.random.default_rng(seed)
        n = len(self.plan.time)
        added = {name: sigma * rng.standard_normal(n) for name, sigma in noise.items()}
        joints = range(1, self.plan.reference.shape[1] + 1)
        seen = np.column_stack([added.get(motor_of(k), np.zeros(n)) for k in joints])
        frame = run(replace(self.plan, reference=self.plan.reference - seen), parameters)
        for k in joints:
            frame[reference_of(k)] = self.plan.reference[:, k - 1]
        for name, values in added.items():
            frame[name] = frame[name] + values
        return Log(frame, f"replica of {self.log.source}")


def repeat(robot: Robot, log: Log) -> tuple[Robot, Repeat]:
    """The robot with the controller that the replica runs under, and the plan. `robot` must be fitted."""
    joints = [k for k, _ in robot.numbered]
    time = log.signals(["time"])[:, 0]
    time = time - time[0]
    if robot.controller is not None and all(reference_of(k) in log.frame for k in joints):
        columns = [feedforward_of(k) for k in joints]
        feedforward = log.frame.reindex(columns=columns).fillna(0.0).to_numpy()
        return robot, Repeat(
            log, Experiment(time, log.signals([reference_of(k) for k in joints]), feedforward)
        )
    tau = log.signals([torque_of(k) for k in joints])
    measured = log.signals([motor_of(k) for k in joints])
    q = log.signals(robot.coordinates)[:1]
    still = Motion(q, 0 * q, 0 * q, tau[:1], time[:1])
    values = np.array(list(robot.linear_parameters.values()))
    weight = (regressor(robot, still).matrix[0] @ values)[: len(joints)]
    plan = Experiment(time, measured, tau - weight)
    return replace(robot, controller=_stand_in(robot, q, log.period)), Repeat(log, plan)


def sensor_noise(repeat: Repeat, simulated: pd.DataFrame, coordinates: tuple[str, ...]) -> dict[str, float]:
    """coordinate -> standard deviation of its white noise, from where a simulation cannot follow it."""
    found = {}
    for name in coordinates:
        difference = (repeat.log.frame[name] - simulated[name]).to_numpy()
        spectrum = np.abs(np.asarray(rfft(np.diff(difference, 1) * np.hanning(len(difference) - 1)))) ** 2
        f = np.linspace(0, 1, len(spectrum))
        gain = 4 * np.sin(np.pi * f / 2) ** 2 * np.sum(np.hanning(len(difference) - 1) ** 2)
        high = f > _NOISE_BAND
        found[name] = float(np.sqrt(np.median(spectrum[high] / gain[high]) / _MEDIAN))
    return found


def _stand_in(robot: Robot, q: np.ndarray, period: float) -> Controller:
    """PD gains that follow the motion at a bandwidth of about 10 Hz, from the model's own mass matrix."""
    values = np.array(list(robot.linear_parameters.values()))
    joints = len(robot.joints)
    Kp, Kd = [], []
    omega = 2 * np.pi * min(_BANDWIDTH, 0.02 / period)
    for k in range(joints):
        unit = np.zeros_like(q)
        unit[0, k] = 1.0
        force = [
            regressor(robot, Motion(q, 0 * q, a, np.zeros((1, joints)), np.zeros(1))).matrix[0, k] @ values
            for a in (unit, 0 * unit)
        ]
        inertia = float(force[0] - force[1])
        Kp.append(inertia * omega**2)
        Kd.append(2 * inertia * omega)
    return Controller(1 / period, tuple(Kp), tuple(Kd), (0.0,) * joints)
