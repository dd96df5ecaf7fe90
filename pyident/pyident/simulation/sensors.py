"""What sensors make of a simulated motion, where nothing is known of the loop that read them.

A controller that stands in for a loop tracks the measured motion, and what it would answer to their noise is
its own doing. So the simulation is without noise, and its log is read as the measured one was: positions
rounded to the steps of their encoders, a twist that is the difference of two encoders with the rounding of
both, torques with noise of the spectrum that the log shows. Rounding is not white: at little speed most of it
is as slow as the motion.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition, derivatives_of, hat_means
from pyident.logs.encoders import resolution, second_encoders
from pyident.logs.log import Log
from pyident.regression.regressor import residual_of
from pyident.simulation.along import along
from pyident.simulation.noise.noise_spectrum import NoiseSpectrum, between_reversals, bridged


@dataclass(frozen=True)
class Sensors:
    """Of one log.

    coordinates  that are measured, in their order
    steps        of channels, and of links where a twist is the difference of two encoders; 0: none
    torques      name -> its noise, without rounding
    seconds      twist -> motor position, of such joints
    held         whether the torques are held from their sample on, as a simulation's are
    """

    coordinates: tuple[str, ...]
    steps: Mapping[str, float]
    torques: Mapping[str, NoiseSpectrum]
    seconds: Mapping[str, str]
    held: bool

    def read(self, frame: pd.DataFrame, noise: Mapping[str, float], seed: int) -> pd.DataFrame:
        """A simulation's log as they show it; noise: channel -> standard deviation, rounding included."""
        rng, out = np.random.default_rng(seed), frame.copy()
        twists = {n for n in self.seconds if n in self.coordinates}
        for name in [n for n in self.coordinates if n not in twists]:
            out[name] = self._rounded(name, frame[name].to_numpy(float), noise.get(name, 0.0), rng)
        for name in sorted(twists):
            motor = self.seconds[name]
            link = (frame[name] + frame[motor]).to_numpy(float)
            out[name] = self._rounded(name, link, noise.get(name, 0.0), rng) - out[motor]
        for name, spectrum in self.torques.items():
            torque = frame[name].to_numpy(float)
            if not self.held:  # about a sample half of the one before it acts
                torque = (torque + np.concatenate([torque[:1], torque[:-1]])) / 2
            out[name] = _in_steps(torque + spectrum.draw(len(torque), rng), self.steps[name], rng)
        rest = [n for n in noise if n in frame and n not in self.coordinates and n not in self.torques]
        for name in rest:
            out[name] = frame[name] + noise[name] * rng.standard_normal(len(frame))
        return out

    def _rounded(self, name: str, x: np.ndarray, sigma: float, rng: np.random.Generator) -> np.ndarray:
        step = self.steps[name]
        white = np.sqrt(max(sigma**2 - step**2 / 12, 0.0))
        return _in_steps(x + white * rng.standard_normal(len(x)), step, rng)


def _in_steps(x: np.ndarray, step: float, rng: np.random.Generator) -> np.ndarray:
    """Rounded to steps that begin anywhere; step 0: not at all."""
    if step <= 0:
        return x
    begin = step * rng.uniform()
    return np.round((x - begin) / step) * step + begin


def sensors_of(robot: Robot, log: Log) -> Sensors:
    """Of a log along which a fitted robot leaves the noise of its torques.

    A torque that moves the robot faster than its motion shows without noise is no noise: there is no more of
    this than what the motion leaves with all its noise.
    """
    frame, p = log.frame, np.array(list(robot.linear_parameters.values()))
    seconds = second_encoders(frame)
    channels = {name: frame[name].to_numpy(float) for name in (*robot.coordinates, *robot.torques)}
    channels |= {n: channels[n] + channels[motor] for n, motor in seconds.items() if n in channels}
    path, part = along(robot, log, p), condition(log, robot)
    left = residual_of(robot, part, p)
    torques = {}
    for k, name in enumerate(robot.torques):
        known = part.use[:, k] > 0
        most = between_reversals(bridged(left[:, k], known), known, log.period) if known.any() else None
        torques[name] = path.noise[name].lowered(most) if most else path.noise[name]
    steps = {name: resolution(x) for name, x in channels.items()}
    held = derivatives_of(robot) is hat_means
    return Sensors(tuple(robot.coordinates), steps, torques, seconds, held)
