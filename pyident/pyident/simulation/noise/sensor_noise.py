"""Noise of the sensors, from the regression's own residual.

Where the residual is noise (high frequencies: differences amplify it as f squared) its power per coordinate
is a sum over the sensors, each with its own pattern over the rows. The patterns are measured: a little known
noise is added to one channel of the log after the other, and non-negative least squares finds how much of
each there is. Sensors whose patterns agree cannot be told apart by that; sensors of a kind are then taken as
equally good. A torque's noise is as strong at low frequencies, where little else is: it is no more than the
residual leaves where it is quietest.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.optimize import lsq_linear, nnls

from flexmodels.coordinate import feedforward_of, motor_of, reference_of, torque_of
from flexmodels.robot import Robot
from flexmodels.threads import gathered
from pyident.conditioning.fading import faded
from pyident.conditioning.smooth_motion import channel_noise, top_power
from pyident.conditioning.weak_form import condition
from pyident.logs.encoders import resolution, second_encoders
from pyident.logs.log import Log
from pyident.regression.regressor import residual_of
from pyident.rules.stillness import stands_still
from pyident.simulation.feedforward import controller_torque, recoverable
from pyident.simulation.recorded import loop_of

_FROM, _TO = 0.6, 0.98  # of the band's width
_ROUNDING = 1e-9  # of the largest torque: less is arithmetic
_PARTS = 8  # of the band
_PROBE = 1e-3  # noise added, of a channel's rms change between samples
_ALIKE = 0.6  # weight of "sensors of a kind are equally good" against one part of the band
_SMOOTH = 101  # lines of a spectrum over which the quietest is looked for
_LEAST = 1e-12  # of a variance
_QUIETEST = 1.5  # times its power, as the least of many lines is below them on average


def sensor_noise(robot: Robot, logs: Sequence[Log], p: np.ndarray) -> dict[str, float]:
    """Channel -> standard deviation of its white noise: the coordinates, and measured motor torques.

    p   (P,) linear parameters with which the residual is taken
    Under the controller of the robot file a torque's noise is what its law and a smooth feed-forward do not
    account for.
    """
    known = torque_noise(robot, logs)
    rng = np.random.default_rng(0)
    hinges, sliders = (
        [c.name for c in robot.q if c.is_motor and robot.joints[c.joint - 1].kind == kind]
        for kind in ("revolute", "prismatic")
    )
    kinds = [hinges, sliders, [c.name for c in robot.q if not c.is_motor]]
    if not known:  # each torque is a kind of its own: motors differ in size
        kinds += [[name] for name in robot.torques]
    still = _still(logs, kinds)
    kinds = [moved for kind in kinds if (moved := [name for name in kind if name not in still])]
    unknown = [channel for kind in kinds for channel in kind]
    channels = [*unknown, *(name for name, sigma in known.items() if sigma > 0)]
    if not channels:
        return known | dict.fromkeys(still, 0.0)
    probes = {c: _PROBE * max(float(np.std(np.diff(log.frame[c]))) for log in logs) for c in channels}
    probes = {c: size or known[c] for c, size in probes.items()}  # a torque at one value all the while
    total, patterns, most = [], [], np.full(len(unknown), np.inf)
    for log in logs:
        left, changes = _patterns(robot, log, p, probes, rng)
        total.append(_parts(left, robot, log))
        patterns += [_parts(change, robot, log) for change in changes]
        for at, channel in enumerate(unknown):
            if channel in robot.torques:
                k = robot.torques.index(channel)
                most[at] = min(most[at], _quietest(left[:, k], changes[at][:, k]))
    power = np.reshape(patterns, (len(logs), len(channels), -1)).sum(axis=0).T
    of_torques = np.square([known[name] for name in channels[len(unknown) :]])
    rest = np.maximum(np.sum(total, axis=0) - power[:, len(unknown) :] @ of_torques, 0.0)
    variances = _shared(rest, power[:, : len(unknown)], kinds, most)
    variances = np.minimum(variances * _raised(rest, power[:, : len(unknown)] @ variances), most)
    found = dict(zip(unknown, np.sqrt(variances).tolist(), strict=True))
    encoders = [name for name in found if name in robot.coordinates]
    seconds = [second_encoders(log.frame) for log in logs]
    rounded = {name: max(found[name], _rounding(logs, seconds, name)) for name in encoders}
    return known | dict.fromkeys(still, 0.0) | found | rounded


def _rounding(logs: Sequence[Log], seconds: Sequence[Mapping[str, str]], name: str) -> float:
    """What an encoder's steps add, as far as its highest frequencies show it; of a second one its own.

    seconds   per log, as of `second_encoders`
    """
    least = []
    for log, second in zip(logs, seconds, strict=True):
        motor = second.get(name)
        x = log.frame[name].to_numpy(float) + (log.frame[motor].to_numpy(float) if motor else 0.0)
        least.append(min(resolution(x) / np.sqrt(12), channel_noise(x)))
    return float(np.sqrt(np.mean(np.square(least))))


def _still(logs: Sequence[Log], kinds: Sequence[Sequence[str]]) -> list[str]:
    """Channels that read one value throughout each log: no noise is in them."""
    still = []
    for kind in kinds:
        courses = {name: [log.frame[name].to_numpy(float) for log in logs] for name in kind}
        largest = max((float(np.abs(x).max()) for each in courses.values() for x in each), default=0.0)
        still += [n for n, each in courses.items() if all(stands_still(x, beside=largest) for x in each)]
    return still


def torque_noise(robot: Robot, logs: Sequence[Log]) -> dict[str, float]:
    """Torque -> standard deviation of its white noise; empty where the controller does not tell it.

    The law of the controller holds sample by sample, so what is left of the torque is the feed-forward, which
    is smooth, and noise, which is not.
    """
    if robot.controller is None or any(loop_of(robot, log) is not None for log in logs):
        return {}
    if not all(recoverable(robot, log) for log in logs):
        return {}
    found: dict[str, list[float]] = {}
    for log in logs:
        joints = [k for k, _ in robot.numbered]
        r, e, tau = (log.signals([name(k) for k in joints]) for name in (reference_of, motor_of, torque_of))
        names = [feedforward_of(k) for k in joints]
        given = log.frame.reindex(columns=names).fillna(0.0).to_numpy()
        rest = tau - controller_torque(robot.controller, r, e) - given
        for k, values, torque in zip(joints, rest.T, tau.T, strict=True):
            found.setdefault(torque_of(k), []).append(_white(values, _ROUNDING * float(np.abs(torque).max())))
    return {name: float(np.sqrt(np.mean(np.square(each)))) for name, each in found.items()}


def _white(values: np.ndarray, least: float) -> float:
    """Standard deviation of white noise in a smooth signal, by its highest frequencies; 0 below least."""
    sigma = float(np.sqrt(np.median(top_power(values)) / np.log(2)))
    return sigma if sigma > least else 0.0


def _shared(
    total: np.ndarray, patterns: np.ndarray, kinds: Sequence[Sequence[str]], most: np.ndarray | float = np.inf
) -> np.ndarray:
    """Variance per channel with total = patterns · variances, sensors of a kind alike where that is open.

    most   (channels,) that they may have
    """
    seen = total > 0
    A, y = patterns[seen] / total[seen, None], np.ones(int(seen.sum()))
    members = np.repeat(np.eye(len(kinds)), [len(kind) for kind in kinds], axis=0)
    if not A.any():  # no equation is in use that shows any of them
        return np.zeros(A.shape[1])
    unit = np.linalg.norm(A @ members, axis=0)
    unit[unit == 0] = 1.0
    of_kind = nnls(A @ members / unit, y)[0] / unit
    typical = np.maximum(members @ of_kind, 1e-6 / np.linalg.norm(A, axis=0).max())
    alike = _ALIKE * (np.eye(len(typical)) - members @ members.T / (members.sum(axis=0) @ members.T)[:, None])
    rows, wanted = np.vstack([A * typical, alike]), np.concatenate([y, np.zeros(len(typical))])
    highest = np.maximum(most / typical, _LEAST)  # else there is nothing between the bounds
    return np.maximum(lsq_linear(rows, wanted, (0, highest), method="bvls").x, 0.0) * typical


def _raised(power: np.ndarray, told: np.ndarray) -> float:
    """By what all variances fall short: powers that scatter by a fifth read low, each relative to itself.

    Sums over the band scatter little, and the middle of the equations is none that lacks something else.
    """
    power, told = power.reshape(-1, _PARTS), told.reshape(-1, _PARTS)
    heard = (power > 0).all(axis=1) & (told > 0).all(axis=1)
    if not heard.any():
        return 1.0
    power, told = power[heard], told[heard]
    course = (power / power.mean(axis=1, keepdims=True)).mean(axis=0)
    return float(np.median((power / course).sum(axis=1) / (told / course).sum(axis=1)))


def _quietest(left: np.ndarray, change: np.ndarray) -> float:
    """Variance of white noise of a torque that fills the quietest lines of what a log leaves of its equation.

    left, change   (lines,) power of the residual and of unit noise
    """
    noise, heard = (
        uniform_filter1d(power, min(_SMOOTH, len(power)), mode="nearest") for power in (change, left)
    )
    if not (noise > 0).all():
        return np.inf
    return float(_QUIETEST * (heard / noise).min())


def _patterns(
    robot: Robot, log: Log, p: np.ndarray, probes: Mapping[str, float], rng: np.random.Generator
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Spectra (lines, n) of a log's residual, and per channel of unit noise in it; probes: channel -> std.

    Noise of a motor's encoder is in the twist as well, where this is what a second one reads beside it.
    """
    noise = {channel: size * rng.standard_normal(len(log.frame)) for channel, size in probes.items()}
    part = faded(condition(log, robot))
    residual, seconds = residual_of(robot, part, p), second_encoders(log.frame)

    def pattern(channel: str) -> np.ndarray:
        frame = log.frame.copy()
        frame[channel] = frame[channel] + noise[channel]
        for twist in (twist for twist, motor in seconds.items() if motor == channel):
            frame[twist] = frame[twist] - noise[channel]
        again = condition(replace(log, frame=frame), robot)
        noisy = replace(again, use=part.use)  # another mask's edge is no noise
        return _spectrum(residual_of(robot, noisy, p) - residual) / max(probes[channel], 1e-300) ** 2

    return _spectrum(residual), gathered(pattern, probes)


def _spectrum(residual: np.ndarray) -> np.ndarray:
    """(N // 2 + 1, n) power of a residual (N, n) per line."""
    return np.abs(np.fft.rfft(residual * np.hanning(len(residual))[:, None], axis=0)) ** 2


def _parts(power: np.ndarray, robot: Robot, log: Log) -> np.ndarray:
    """Mean of a spectrum (lines, n) per coordinate and part of the noise band, as one vector."""
    cutoff = robot.settings.processing.cutoff
    top = len(power) * min(1.0, 2 * cutoff * log.period if cutoff else 1.0)
    edges = np.linspace(_FROM * top, _TO * top, _PARTS + 1).astype(int)
    return np.array([power[a:b].mean(axis=0) for a, b in pairwise(edges)]).T.ravel()
