"""The digital controller around any plant, and the state from which every plant starts."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flexmodels.experiment import Experiment
from flexmodels.mechanics.plant import Equations
from flexmodels.robot import Robot


class Plant(Protocol):
    """A simulated arm whose torque is held while it advances; vectors in the order of the robot."""

    def reset(self, q: np.ndarray) -> None:
        """At rest at the coordinates q (as `robot.coordinates`)."""
        ...

    def advance(self, torque: np.ndarray) -> None:
        """One period of the controller."""
        ...

    def angles(self) -> np.ndarray:
        """Of the motor hinges [rad]."""
        ...

    def tip(self) -> np.ndarray:
        """Position [m]."""
        ...


@dataclass(frozen=True)
class Start:
    """Static equilibrium: coordinates q and the torque that the motors hold."""

    q: np.ndarray
    torque: np.ndarray


def static_start(equations: Equations, reference: np.ndarray) -> Start:
    """Motor hinges at the reference, deformations under the weight."""
    p, joints = equations.parameters, equations.joints
    stiffness = np.array([p[name.replace("eps", "k")] for name in equations.coordinates[joints:]])
    x = np.zeros(2 * len(equations.coordinates))
    x[:joints] = reference
    for _ in range(50):
        x[joints : len(equations.coordinates)] -= _weight(equations, x)[joints:] / stiffness
    return Start(x[: len(equations.coordinates)], _weight(equations, x)[:joints])


def run(plant: Plant, robot: Robot, experiment: Experiment, start: Start) -> np.ndarray:
    """Tip (N, 3) [m] at the samples of the experiment."""
    c = robot.controller
    assert c is not None
    Kp, Kd, Ki = np.array(c.Kp), np.array(c.Kd) / c.period, np.array(c.Ki) * c.period
    plant.reset(start.q)
    integral, before, tip = start.torque, None, [plant.tip()]
    inputs = zip(experiment.reference[:-1], experiment.feedforward[:-1], strict=True)
    for r, feedforward in inputs:
        error = r - plant.angles()
        torque = Kp * error + feedforward
        if before is not None:
            integral = integral + Ki * error
            torque += Kd * (error - before)
        before = error
        plant.advance(torque + integral)
        tip.append(plant.tip())
    return np.array(tip)


def _weight(equations: Equations, x: np.ndarray) -> np.ndarray:
    return np.array(equations.balance(x, list(equations.parameters.values()))).ravel()
