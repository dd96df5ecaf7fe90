"""The equations of a log, as the instrumental estimate takes them.

Where nothing says what drives a rigid robot, its motion is taken without the encoders' noise, as a diagnosis
takes it: differenced twice, that noise exceeds the torque where samples are dense, and what it leaves in an
instrument or at the edge of a mask is more than the inertias have. In a known loop the noise stays, for what
a controller makes of it is in the torque, and the equations carry it (`noise_scatter`); so it does where the
robot's file has a filter for it.
"""

from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.logs.log import Log
from pyident.refinement.instruments.stand_in import driven
from pyident.simulation.denoised import denoised, denoises


def quiet(robot: Robot) -> bool:
    """Whether the motion of its logs loses the encoders' noise before it is differenced."""
    return denoises(robot) and not driven(robot) and not robot.settings.processing.filters


def logged(robot: Robot, log: Log) -> Conditioned:
    """As `condition`, without noise where it is to be lost. Raises LogError."""
    return denoised(robot, log) if quiet(robot) else condition(log, robot)
