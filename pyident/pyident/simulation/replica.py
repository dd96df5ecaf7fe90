"""Replicas: logs as the fitted model would have made them, over the same motion with the same sensor noise.

What the identical analysis finds in a replica is not physics but the method's own trace. Where the log holds
references and the robot file the controller that made it, the replica is the same closed loop; else it tracks
the measured motion under a stabilising controller with the measured torque fed forward.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.fft import rfft

from flexmodels.coordinate import motor_of, reference_of, torque_of
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.logs.encoders import noise_of, second_encoders
from pyident.logs.log import Log
from pyident.simulation.along import AlongMotion
from pyident.simulation.feedforward import carrying_torque
from pyident.simulation.noise.noise_spectrum import NoiseSpectrum
from pyident.simulation.recorded import AT_REST, Recorded, loop_of, recorded
from pyident.simulation.sensors import Sensors, sensors_of
from pyident.simulation.servo_torque import with_servo_torque
from pyident.simulation.simulator import Simulator
from pyident.simulation.stabilising import stabilising_controller

Run = Callable[[Experiment, Mapping[str, float]], pd.DataFrame]

_NOISE_BAND = 0.8  # of the Nyquist frequency: above, a log that differs from its simulation differs by noise
_FIRST, _POINTS = 0.1, 9  # s, samples: the beginning of a motion that a cubic describes
_MEDIAN = np.log(2)  # of a periodogram's ordinate, per its mean


@dataclass(frozen=True)
class Repeat:
    """How a log can be made again: `plan` for the closed loop, `log` for what it must look like.

    lead   samples of the plan before the log
    note   why it is not the robot's own loop, but a stand-in's along the measured motion; None where it is
    sensors   that read what a stand-in's loop does; None: noise goes through the robot's own
    servos    the robot whose servos the log's torques are made by, from commands and positions; None: by none
    """

    log: Log
    plan: Experiment
    lead: int = 0
    note: str | None = None
    sensors: Sensors | None = None
    servos: Robot | None = None

    def noisier(self, noise: Mapping[str, float], seed: int) -> Log:
        """The log itself with the noise of its sensors once more; noise: channel -> standard deviation."""
        drawn, rng = self._drawn(noise, seed), np.random.default_rng([seed, 1])
        for name, spectrum in torque_spectra(self).items():
            drawn[name] = spectrum.draw(len(self.plan.time), rng)
        own = slice(self.lead, self.lead + len(self.log.frame))
        changed = {name: self.log.frame[name] + values[own] for name, values in drawn.items()}
        return replace(self.log, frame=self.log.frame.assign(**changed))

    def cut(self, frame: pd.DataFrame) -> pd.DataFrame:
        """A simulation of the plan without what comes before the log."""
        return Recorded(self.plan, self.lead).cut(frame)

    def replica(
        self, run: Run, parameters: Mapping[str, float], noise: Mapping[str, float], seed: int
    ) -> Log:
        """The log's motion made by a model; noise: coordinate -> standard deviation of its sensor."""
        if self.sensors:
            return self._read(run(self.plan, parameters), noise, seed)
        added = self._drawn(noise, seed)
        return self._made(with_noise(lambda made: run(made, parameters), self.plan, added), seed)

    def replicas(
        self,
        simulator: Simulator,
        parameters: Mapping[str, float],
        noise: Mapping[str, float],
        seeds: Sequence[int],
    ) -> list[Log]:
        """One per seed, simulated side by side; as `replica`, but that the noise is held between samples."""
        if self.sensors:
            (frame,) = simulator.simulate_batch(self.plan, [parameters])
            return [self._read(frame, noise, seed) for seed in seeds]
        frames = simulator.simulate_batch(self.plan, [parameters], noise, seeds)
        return [self._made(frame, seed) for frame, seed in zip(frames, seeds, strict=True)]

    @cached_property
    def _seconds(self) -> dict[str, str]:
        return second_encoders(self.log.frame)

    def _drawn(self, noise: Mapping[str, float], seed: int) -> dict[str, np.ndarray]:
        rng = np.random.default_rng(seed)
        drawn = {name: sigma * rng.standard_normal(len(self.plan.time)) for name, sigma in noise.items()}
        for twist, motor in self._seconds.items():
            if motor in drawn:
                drawn[twist] = drawn.get(twist, np.zeros_like(drawn[motor])) - drawn[motor]
        return drawn

    def _read(self, frame: pd.DataFrame, noise: Mapping[str, float], seed: int) -> Log:
        """A simulation without noise, as the sensors show it."""
        assert self.sensors is not None
        return self._made(self.sensors.read(_sensed(frame, self.plan, {}), noise, seed), seed)

    def _made(self, frame: pd.DataFrame, seed: int) -> Log:
        frame = self.cut(frame)
        switches = {n: self.log.frame[n].to_numpy() for n in self.log.names if n.endswith(".on")}
        made = replace(self.log, frame=frame.assign(**switches), source=f"replica of {self.log.source}")
        return made if self.servos is None else with_servo_torque(self.servos, self._commanded(made, seed))

    def _commanded(self, log: Log, seed: int) -> Log:
        """With commands that are off by their rounding, which is all that a log tells of them."""
        rng, names = np.random.default_rng([seed, 2]), [n for n in map(str, log.frame) if n.endswith(".r")]
        noise = {n: noise_of(self.log.frame[n].to_numpy(float)) for n in names}
        off = {n: log.frame[n] + sigma * rng.standard_normal(len(log)) for n, sigma in noise.items()}
        return replace(log, frame=log.frame.assign(**off))


def torque_spectra(made: Repeat | AlongMotion) -> Mapping[str, NoiseSpectrum]:
    """Torque -> its noise as the log shows it; empty where a loop that is known tells how white it is."""
    if isinstance(made, AlongMotion):
        return {name: made.noise[name] for name in made.robot.torques}
    return made.sensors.torques if made.sensors else {}


def side_by_side(
    simulator: Simulator,
    wanted: Sequence[tuple[Repeat, int]],
    parameters: Mapping[str, float],
    noise: Mapping[str, float],
) -> list[Log]:
    """A replica of each log under its seed, as `Repeat.replica` makes them one by one."""
    if all(r.sensors for r, _ in wanted):
        apart = list({id(r): r for r, _ in wanted}.values())
        made = simulator.simulate_batch([r.plan for r in apart], [parameters])
        frames = {id(r): frame for r, frame in zip(apart, made, strict=True)}
        return [r._read(frames[id(r)], noise, seed) for r, seed in wanted]
    drawn = [(r, r._drawn(noise, seed)) for r, seed in wanted]
    frames = simulator.simulate_batch([_disturbed(r.plan, added) for r, added in drawn], [parameters])
    made = zip(frames, drawn, (seed for _, seed in wanted), strict=True)
    return [r._made(_sensed(f, r.plan, added), seed) for f, (r, added), seed in made]


def repeats(robot: Robot, logs: Sequence[Log]) -> tuple[Robot, tuple[Repeat, ...]]:
    """The robot with the controller that all replicas run under, and how each log is made again.

    `robot` must be fitted. One log that the robot's own loop cannot follow takes the others with it.
    """
    for log in logs:
        obstacle = loop_of(robot, log)
        if obstacle:
            motion = np.vstack([each.signals(robot.coordinates) for each in logs])
            controller = stabilising_controller(robot, motion, log.period)
            note = f"{Path(log.source).name} is simulated along its measured motion: {obstacle}"
            return replace(robot, controller=controller), tuple(_along(robot, log, note) for log in logs)
    return robot, tuple(_in_loop(robot, log) for log in logs)


def repeat_like(simulated: Robot, robot: Robot, log: Log) -> Repeat:
    """How another log is made again by what `repeats` chose for some logs of the fitted robot."""
    if simulated.controller is robot.controller and loop_of(robot, log) is None:
        return _in_loop(robot, log)
    note = f"{log.source}: it is simulated along the measured motion"
    return with_sensors(robot, [_along(robot, log, note)])[0]


def with_sensors(robot: Robot, made: Sequence[Repeat]) -> tuple[Repeat, ...]:
    """What a stand-in's loop does, of a fitted robot that bends, read as its log was; others as they are."""
    return tuple(
        replace(r, sensors=sensors_of(robot, r.log)) if r.note and robot.flexible else r for r in made
    )


def _in_loop(robot: Robot, log: Log) -> Repeat:
    inputs = recorded(robot, log)
    return Repeat(log, inputs.plan, inputs.lead, servos=robot if log.by_servo else None)


def _along(robot: Robot, log: Log, note: str) -> Repeat:
    """The measured motion as reference, the measured torque as feed-forward."""
    joints = [k for k, _ in robot.numbered]
    tau = log.signals([torque_of(k) for k in joints])
    measured = log.signals([motor_of(k) for k in joints])
    weight = carrying_torque(robot, log, np.zeros(len(joints)))
    time = log.signals(["time"])[:, 0]
    plan = Experiment(time - time[0], measured, tau - weight, speed=_first_speed(measured, log.period))
    return Repeat(log, plan, note=note)


def _first_speed(q: np.ndarray, period: float) -> np.ndarray:
    """(joints,) of a measured motion q (N, joints) at its first sample; zero where a joint is at rest.

    From a motion at rest the simulation would have to catch up at once, with torques that nothing has shown.
    """
    window = min(len(q), max(_POINTS, round(_FIRST / period)))
    time = period * np.arange(window)
    speed = np.polynomial.polynomial.polyfit(time, q[:window], min(3, window - 1))[1]
    fastest = np.abs(np.diff(q, axis=0)).max(axis=0) / period
    return np.where(np.abs(speed) <= AT_REST * fastest, 0.0, speed)


def with_noise(
    run: Callable[[Experiment], pd.DataFrame], plan: Experiment, noise: Mapping[str, np.ndarray]
) -> pd.DataFrame:
    """A run of the plan whose sensors add noise: channel -> (N,); that of an encoder goes through the loop.

    A controller that reads e + n at the reference r does what it does with e at r - n.
    """
    return _sensed(run(_disturbed(plan, noise)), plan, noise)


def _disturbed(plan: Experiment, noise: Mapping[str, np.ndarray]) -> Experiment:
    joints = range(1, plan.reference.shape[1] + 1)
    seen = np.column_stack([noise.get(motor_of(k), np.zeros(len(plan.time))) for k in joints])
    return replace(plan, reference=plan.reference - seen)


def _sensed(frame: pd.DataFrame, plan: Experiment, noise: Mapping[str, np.ndarray]) -> pd.DataFrame:
    for k in range(1, plan.reference.shape[1] + 1):
        frame[reference_of(k)] = plan.reference[:, k - 1]
    for name, values in noise.items():
        frame[name] = frame[name] + values
    return frame


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
