"""The equations of a log whose motion has lost its sensors' noise.

Differences amplify the noise of encoders, and in a regressor noise is no residual: it bends the parameters
(errors in variables), differently along every motion. What that leaves is a floor at low frequencies, where
physics is, and an error of prediction on held-out logs. Where the loop of a rigid robot is unknown and its
file names no cutoff, the motion is therefore taken as a low pass leaves it whose corner is where its spectrum
nears the noise. The torques keep all their frequencies.
"""

from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.rest import without_steps
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition, condition_every_sample
from pyident.logs.log import Log
from pyident.simulation.along import smooth_motion
from pyident.simulation.sensor_noise import channel_noise
from pyident.simulation.smooth_motion import blurred, ends_of, reached


def denoised(robot: Robot, log: Log) -> Conditioned:
    """As `condition`, of the motion without its noise. Raises LogError."""
    return _relied_on(robot, log, condition(_smooth(robot, log), robot))


def denoised_every_sample(robot: Robot, log: Log) -> Conditioned:
    """As `condition_every_sample`. Raises LogError."""
    return _relied_on(robot, log, condition_every_sample(_smooth(robot, log), robot))


def corners(robot: Robot, log: Log) -> np.ndarray:
    """(n,) frequency [Hz] up to which each coordinate's motion stands clear of noise; infinite: not asked."""
    if not denoises(robot):
        return np.full(len(robot.coordinates), np.inf)
    nyquist = 0.5 / log.period
    return np.array([nyquist * reached(x, channel_noise(x)) for x in log.signals(robot.coordinates).T])


def denoises(robot: Robot) -> bool:
    """Whether the motion loses its noise and a torque's has a spectrum; a cutoff of the file forbids it."""
    rigid = not any(joint.flexible for joint in robot.joints)
    return rigid and robot.controller is None and robot.settings.processing.cutoff is None


def _smooth(robot: Robot, log: Log) -> Log:
    if not denoises(robot):
        return log
    frame = log.frame.copy()
    frame[list(robot.coordinates)] = smooth_motion(robot, log)
    return replace(log, frame=frame)


def _relied_on(robot: Robot, log: Log, part: Conditioned) -> Conditioned:
    """Without the ends, and where a low pass blurs the step of an acceleration when friction turns round."""
    if not denoises(robot):
        return part
    use = part.use.copy()
    blurs = [blurred(x, channel_noise(x)) for x in log.signals(robot.coordinates).T]
    for k, blur in enumerate(blurs):
        use[:, k] *= without_steps(use[:, k] > 0, part.motion.ddq[:, k], blur)
    ends = ends_of(len(use), blurs)
    use[:ends], use[-ends:] = 0.0, 0.0
    return replace(part, use=use)
