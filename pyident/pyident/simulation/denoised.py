"""The equations of a log whose motion has lost its sensors' noise.

Differences amplify the noise of encoders, and in a regressor noise is no residual: it bends the parameters
(errors in variables), differently along every motion. What that leaves is a floor at low frequencies, where
physics is, and an error of prediction on held-out logs. Where the loop of a rigid robot is unknown, the
motion is therefore taken as a low pass leaves it whose corner is where its spectrum nears the noise. The
torques keep all their frequencies. Elsewhere the noise stays in the motion, and equations fade in and out at
reversals: at a hard edge the noise of high frequencies would be at the low ones, too.

The filter of the robot's file would do less: it bends the motion about its corner, blurs reversals and leaves
them in, and thins out. It only ends the band that is judged (`unfiltered`); but it stays for joints that bend
in an unknown loop, as their motion keeps its noise.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.fading import faded
from pyident.conditioning.reversals.other_reversals import all_telling
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.smooth_motion import all_reached, all_smooth, blurred, ends_of
from pyident.conditioning.weak_form import condition, condition_every_sample, switching
from pyident.logs.log import Log
from pyident.regression.spectrum import Equations, band_top, equations


def denoised(robot: Robot, log: Log) -> Conditioned:
    """As `condition`, of the motion without its noise. Raises LogError."""
    return _without_noise(robot, log, condition)


def denoised_every_sample(robot: Robot, log: Log) -> Conditioned:
    """As `condition_every_sample`. Raises LogError."""
    return _without_noise(robot, log, condition_every_sample)


def denoised_equations(robot: Robot, logs: Sequence[Log]) -> list[Equations]:
    """Every log's, transformed. Raises LogError."""
    parts = [denoised_every_sample(robot, log) for log in logs]
    return equations(robot, parts, [log.period for log in logs])


def corners(robot: Robot, log: Log) -> np.ndarray:
    """(n,) frequency [Hz] up to which each coordinate's motion stands clear of noise; infinite: not asked."""
    if not denoises(robot):
        return np.full(len(robot.coordinates), np.inf)
    return 0.5 / log.period * np.array(all_reached(log.signals(robot.coordinates)))


def where_moving(robot: Robot, logs: Sequence[Log], transformed: Sequence[Equations]) -> list[np.ndarray]:
    """Per log (n, E): where an equation's coordinate moves and is not noise alone.

    transformed   the same logs' equations
    Beyond, a column holds what the low pass of the motion left, and a torque the answer of a controller to
    the noise of encoders.
    """
    pairs = zip(logs, transformed, strict=True)
    return [np.tile(e.band.frequencies, 2) <= corners(robot, log)[:, None] for log, e in pairs]


def denoises(robot: Robot) -> bool:
    """Whether the motion loses its noise and a torque's has a spectrum."""
    return robot.controller is None and not robot.flexible


def unfiltered(robot: Robot, logs: Sequence[Log]) -> Robot:
    """The robot without its file's filter, where replicas need none of it."""
    return robot if robot.flexible and robot.controller is None else without_filter(robot, logs)


def without_filter(robot: Robot, logs: Sequence[Log]) -> Robot:
    """The robot without its file's filter, judged up to where the equations would be sound with it."""
    plan = robot.settings.processing
    if not plan.filters:
        return robot
    band = min(band_top(robot, log.period) for log in logs)
    return within(robot.with_settings(processing=replace(plan, cutoff=None, decimate=1)), band)


def within(robot: Robot, highest: float) -> Robot:
    """The robot judged up to a frequency [Hz] at most."""
    plan = robot.settings.processing
    if not np.isfinite(highest):
        return robot
    return robot.with_settings(processing=replace(plan, band=min(highest, plan.band or np.inf)))


def _without_noise(robot: Robot, log: Log, conditioned: Callable[[Log, Robot], Conditioned]) -> Conditioned:
    """Nor its ends, nor where a low pass blurs a step of the acceleration: a reversal of friction, a jerk, a
    servo that goes on or off.
    """
    if not denoises(robot):
        return faded(conditioned(log, robot))
    q, frame = log.signals(robot.coordinates), log.frame.copy()
    reach = all_reached(q)
    frame[list(robot.coordinates)] = all_smooth(q, reach)
    part = conditioned(replace(log, frame=frame), robot)
    use = part.use * all_telling(part.use > 0, part.target, part.motion, reach, log.period)
    spread = [blurred(corner) for corner in reach]
    ends = ends_of(len(use), spread)
    use[:ends], use[-ends:] = 0.0, 0.0
    use[switching(log, robot, max(spread), len(use))] = 0.0
    return replace(part, use=use)
