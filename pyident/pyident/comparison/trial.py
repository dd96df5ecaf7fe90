"""A model and the logs that it is held against, and how these are made again.

A rigid robot whose loop nobody knows is judged as in a diagnosis: its motion without the encoders' noise,
replicas along the measured motion, with torque noise of the spectrum that theirs has. Its simulation, under a
controller that stands in for the loop, tells beside that which torques the model needs.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import Estimator, weighted
from pyident.kinematics.transfer import tip_positions
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.simulation.along import AlongMotion, along_each, mean_noise
from pyident.simulation.denoised import denoised
from pyident.simulation.noise.sensor_noise import sensor_noise
from pyident.simulation.replica import Repeat, repeats, side_by_side, with_sensors
from pyident.simulation.simulator import Simulator

TIP = ("tip.x", "tip.y", "tip.z")


@dataclass(frozen=True)
class Trial:
    """A model and the logs that it is held against.

    robot       the model;  simulated: with the controller that its simulations run under
    fitted      logs from which parameters are found;  judged: those on which errors are taken
    since       per judged log the time [s] from which on it counts
    noise       signal -> standard deviation of its sensor
    estimator   finds values anew in logs and replicas
    paths       how each log, fitted ones first, is made again along its motion; none: by simulation
    """

    robot: Robot
    simulated: Robot
    fitted: tuple[Repeat, ...]
    judged: tuple[Repeat, ...]
    since: tuple[float, ...]
    noise: dict[str, float]
    estimator: Estimator = weighted
    paths: tuple[AlongMotion, ...] = ()

    @property
    def repeats(self) -> list[Repeat]:
        """Of all logs, fitted ones first, each once."""
        return list({id(r): r for r in (*self.fitted, *self.judged)}.values())

    def along(self, robot: Robot, p: np.ndarray) -> "Trial":
        """The same along the measured motions; robot: fitted, p (P,) its linear parameters."""
        paths = along_each(robot, [r.log for r in self.repeats], p)
        return replace(self, noise=mean_noise(paths), paths=paths)

    def conditioned(self, log: Log, robot: Robot) -> Conditioned:
        """The equations of one of its logs. Raises LogError."""
        return denoised(robot, log) if self.paths else condition(log, robot)

    @property
    def tracks(self) -> bool:
        """Whether a stand-in controller makes the simulation follow the measured motion."""
        return self.simulated.controller is not self.robot.controller


def on_trial(robot: Robot, logs: Sequence[Log]) -> Trial:
    """A model with its own parameters against logs. Raises LogError."""
    simulated, plain = repeats(robot, logs)
    made_again = with_sensors(robot, plain)
    judged = made_again, made_again, (0.0,) * len(logs)
    if robot.flexible or simulated.controller is robot.controller:
        found = weighted(Problem(robot, tuple(condition(log, robot) for log in logs)))
        noise = sensor_noise(found.problem.robot, logs, found.solution.p)
        return Trial(robot, simulated, *judged, noise)
    found = weighted(Problem(robot, tuple(denoised(robot, log) for log in logs)))
    return Trial(robot, simulated, *judged, {}).along(found.problem.robot, found.solution.p)


def again(fmu: Simulator, trial: Trial, drawn: Sequence[Sequence[int]]) -> Sequence[Sequence[Log]]:
    """A replica of every log of a trial for each row of seeds."""
    return _along_paths(trial, drawn) if trial.paths else _simulated(fmu, trial, drawn)


def _simulated(fmu: Simulator, trial: Trial, drawn: Sequence[Sequence[int]]) -> list[list[Log]]:
    wanted = [pair for seeds in drawn for pair in zip(trial.repeats, seeds, strict=True)]
    logs, count = side_by_side(fmu, wanted, trial.robot.parameters, trial.noise), len(trial.repeats)
    return [logs[first : first + count] for first in range(0, len(logs), count)]


def _along_paths(trial: Trial, drawn: Sequence[Sequence[int]]) -> list[tuple[Log, ...]]:
    parameters = trial.robot.parameters
    pairs = zip(trial.paths, zip(*drawn, strict=True), strict=True)
    made = [_with_tips(trial, path, path.replicas(parameters, seeds), seeds) for path, seeds in pairs]
    return list(zip(*made, strict=True))


def _with_tips(trial: Trial, path: AlongMotion, made: Sequence[Log], seeds: Sequence[int]) -> Sequence[Log]:
    """Replicas along a path with the tip that its motion has, and noise on it, where the log tells a tip."""
    seen = [axis for axis, name in enumerate(TIP) if name in path.log.frame]
    if not seen:
        return made
    tip = tip_positions(trial.robot, path.motion.q)
    for log, seed in zip(made, seeds, strict=True):
        rng = np.random.default_rng([seed, len(seen)])
        for axis in seen:
            log.frame[TIP[axis]] = tip[:, axis] + trial.noise[TIP[axis]] * rng.standard_normal(len(tip))
    return made
