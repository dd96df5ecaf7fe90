"""Replicas along the measured motion, for a rigid robot whose loop nobody knows.

A stand-in controller moves otherwise than the robot did, and its floor would be its own doing. So nothing is
simulated: the motion is the measured one without its noise, the torques are those that the model needs for
it (inverse dynamics), and noise is put on both: white on the motion, on the torques with the spectrum that
theirs has in the log. Every replica has parameters of its own, drawn from the fit's covariance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.conditioning.order_waves import highest_of, orders_within, without_waves
from pyident.conditioning.reversals.other_reversals import all_telling
from pyident.conditioning.reversals.rest import away_from_rest
from pyident.conditioning.reversals.rubbing import signs_known, speed_products
from pyident.conditioning.smooth_motion import (
    WHITE_FROM,
    all_smooth,
    blurred,
    channel_noise,
    ends_of,
    reached,
)
from pyident.conditioning.weak_form import REACH, central_differences
from pyident.logs.encoders import resolution
from pyident.logs.log import Log
from pyident.regression.regressor import generalised_forces, regressor_blocks
from pyident.rules.periodic import PeriodicRules
from pyident.rules.rules import RULES
from pyident.simulation.denoised import denoises
from pyident.simulation.noise.noise_spectrum import (
    NoiseSpectrum,
    between_reversals,
    bridged,
    repeated_spectrum,
    share_told,
)
from pyident.simulation.noise.repetition import Repetition, repetition_of
from pyident.simulation.noise.rounding import Rounding
from pyident.simulation.noise.sensor_noise import sensor_noise

_ALONE = 0.5  # of the power of an encoder's noise: rounding that no other noise blurs


@dataclass(frozen=True)
class AlongMotion:
    """How a log can be made again without its loop.

    motion    the smooth one
    steps     coordinate or torque -> its resolution, 0: none
    noise     coordinate or torque -> its noise, rounding apart
    spread    (P, R): a draw of R standard normal numbers becomes a change of the parameters
    """

    log: Log
    robot: Robot
    motion: Motion
    steps: Mapping[str, float]
    noise: Mapping[str, NoiseSpectrum]
    spread: np.ndarray

    def replicas(self, parameters: Mapping[str, float], seeds: Sequence[int]) -> list[Log]:
        """The log's motion with the torques of a model, one per seed."""
        chance = [np.random.default_rng(seed) for seed in seeds]
        p = np.array([parameters[name] for name in self.robot.linear_parameters])
        drawn = [p + self.spread @ rng.standard_normal(self.spread.shape[1]) for rng in chance]
        joints, P = len(self.robot.joints), np.column_stack(drawn)
        torques = np.concatenate(
            [(Phi @ P)[:, :joints] for _, Phi in regressor_blocks(self.robot, self.motion)]
        )
        return [
            self._noisy(torque, rng) for torque, rng in zip(torques.transpose(2, 0, 1), chance, strict=True)
        ]

    def _noisy(self, torque: np.ndarray, rng: np.random.Generator) -> Log:
        """The log with the smooth motion and `torque` (N, joints), noise on both."""
        frame = self.log.frame.copy()
        made = dict(zip(self.robot.coordinates, self.motion.q.T, strict=True))
        made |= dict(zip(self.robot.torques, torque.T, strict=True))
        for name, values in made.items():
            noisy = values + self.noise[name].draw(len(values), rng)
            step = self.steps.get(name, 0.0)
            frame[name] = np.round(noisy / step) * step if step > 0 else noisy
        return replace(self.log, frame=frame, source=f"replica of {self.log.source}")


def along(
    robot: Robot,
    log: Log,
    p: np.ndarray,
    covariance: np.ndarray | None = None,
    known: Mapping[str, float] | None = None,
    periodic: PeriodicRules = RULES.periodic,
) -> AlongMotion:
    """`robot` is fitted and rigid; p (P,) its linear parameters as found, covariance (P, P): none: exact.

    known   signal -> standard deviation of its noise, which is white and holds rounding; none: it is measured
            in the channels
    periodic   by which waves over a joint's angle are told from noise
    """
    measured = log.signals(robot.coordinates)
    tau = log.signals(robot.torques)
    time = log.signals(["time"])[:, 0]
    noise = np.array([channel_noise(x) for x in measured.T])
    if known is not None:
        noise = np.array([known[name] for name in robot.coordinates])
    corners = [reached(x, sigma) for x, sigma in zip(measured.T, noise, strict=True)]
    q, dq, ddq = central_differences(_extended(all_smooth(measured, corners)), log.period)
    names = [*robot.coordinates, *robot.torques]
    steps = {name: resolution(log.frame[name].to_numpy()) for name in names}
    motion = Motion(q, dq, ddq, tau, time - time[0])
    if known is None:
        white = [NoiseSpectrum.white(sigma, log.period) for sigma in noise]
        spectra = dict(zip(robot.coordinates, white, strict=True))
        step = np.array([steps[name] for name in robot.coordinates])
        alone, repeats = step**2 / 12 > _ALONE * noise**2, repetition_of(measured, noise)
        spectra |= _torque_noise(robot, log, motion, p, repeats, corners, alone, periodic)
    else:
        spectra = {name: NoiseSpectrum.white(known[name], log.period) for name in names}
    apart = {name: spectrum.without_rounding(steps[name]) for name, spectrum in spectra.items()}
    return AlongMotion(log, robot, motion, steps, apart, _spread(covariance, len(p)))


def along_each(
    robot: Robot,
    logs: Sequence[Log],
    p: np.ndarray,
    covariance: np.ndarray | None = None,
    periodic: PeriodicRules = RULES.periodic,
) -> tuple[AlongMotion, ...]:
    """Every log so, p (P,); what a controller in the file does not account for tells the sensors' noise.

    The others as in `along`.
    """
    known = [None if denoises(robot) else sensor_noise(robot, [log], p) for log in logs]
    return tuple(
        along(robot, log, p, covariance, noise, periodic) for log, noise in zip(logs, known, strict=True)
    )


def mean_noise(paths: Sequence[AlongMotion]) -> dict[str, float]:
    """Signal -> standard deviation of its noise, of all logs."""
    return {name: float(np.mean([path.noise[name].std for path in paths])) for name in paths[0].noise}


def _torque_noise(
    robot: Robot,
    log: Log,
    motion: Motion,
    p: np.ndarray,
    repeats: Repetition | None,
    corners: Sequence[float],
    alone: np.ndarray,
    periodic: PeriodicRules,
) -> dict[str, NoiseSpectrum]:
    """Torque -> its noise.

    repeats   where the motion does;  corners: of the coordinates, as of `reached`
    alone     (n,) whether rounding is most of a coordinate's noise
    """
    joints = len(robot.joints)
    tau = log.signals(robot.torques)
    forces = generalised_forces(robot, motion, p)[:, :joints]
    left = tau - forces
    signs = signs_known(robot, motion.dq, speed_products(motion.dq, joints)) > 0
    out, ends = {}, ends_of(len(left), [blurred(corner) for corner in corners])
    above = 2 * max(corners) * 0.5 / log.period
    beside = (log.signals(robot.coordinates) - motion.q) * alone
    rounding = Rounding.of(beside, above, log.period) if repeats else None
    shaken = _shaken(robot, motion, p, rounding, forces) if rounding else []
    away = [away_from_rest(speed, float(np.mean(speed**2))) for speed in motion.dq[:, :joints].T]
    known = np.column_stack(away) & signs[:, :joints]
    told = all_telling(known, tau, motion, corners[:joints], log.period)
    told[:ends], told[-ends:] = False, False
    for k, name in enumerate(robot.torques):
        speed, moving = motion.dq[:, k], told[:, k]
        rest, plain, found = left[:, k], left[:, k], None
        if moving.any():
            highest, angle = highest_of(robot.joints[k], periodic), motion.q[:, k]
            orders = orders_within([angle], np.abs(speed), log.period, highest, periodic)
            plain = bridged(without_waves(rest, angle, speed, moving, orders, periodic), moving)
            found, rest = between_reversals(plain, moving, log.period, above), bridged(rest, moving)
        if repeats:
            again = repeated_spectrum(rest[repeats.rows], repeats.period, log.period)
            again = replace(again, density=again.density / share_told(moving[repeats.rows]))
            if rounding:
                again = again.raised(rounding.answer(bridged(plain, moving)), 0.0).raised(shaken[k], 0.0)
            found = again.raised(found, above) if found else again
        out[name] = found or _of_highest(plain, moving, log.period)
    return out


def _shaken(
    robot: Robot, motion: Motion, p: np.ndarray, rounding: Rounding, forces: np.ndarray
) -> list[NoiseSpectrum]:
    """Torque of every joint, by parameters p (P,), of the shaking that encoders' noise has hidden.

    forces   (N, joints) of the motion without it
    """
    moved = replace(motion, ddq=motion.ddq + rounding.shaken)
    torque = generalised_forces(robot, moved, p)[:, : forces.shape[1]] - forces
    return [rounding.spectrum(x) for x in torque.T]


def _of_highest(rest: np.ndarray, moving: np.ndarray, period: float) -> NoiseSpectrum:
    """White noise by the highest frequencies of what is left (N,), of which straight lines hold none."""
    white = NoiseSpectrum.white(channel_noise(rest) / np.sqrt(share_told(moving)), period)
    return replace(white, continued=WHITE_FROM * 0.5 / period)


def _extended(q: np.ndarray) -> np.ndarray:
    """(N + 2 REACH, n): continued point-symmetrically at both ends."""
    first = 2 * q[:1] - q[REACH:0:-1]
    last = 2 * q[-1:] - q[-2 : -REACH - 2 : -1]
    return np.concatenate([first, q, last])


def _spread(covariance: np.ndarray | None, size: int) -> np.ndarray:
    if covariance is None:
        return np.zeros((size, 0))
    w, V = np.linalg.eigh(covariance)
    kept = w > 1e-12 * max(float(w[-1]), 1e-300)
    return V[:, kept] * np.sqrt(w[kept])
