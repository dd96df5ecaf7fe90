"""Instruments where nothing says how the torque of the logs was made.

A controller stands in that follows the measured motion, without its highest frequencies, as their noise
would pass into the instruments. It is fed the torque that the model found so far needs for that motion: the
noise of the measured one would shake the arm that it drives, and a joint's inertia would be found too large
by what it shakes. It holds its torque between samples and the log's was not held, so that what its equations
leave says nothing of the log's.
"""

from dataclasses import replace

import numpy as np

from flexmodels.coordinate import torque_of
from flexmodels.robot import Robot
from pyident.conditioning.filters import without_phase
from pyident.conditioning.motion import Motion
from pyident.conditioning.smooth_motion import all_reached
from pyident.regression.regressor import generalised_forces
from pyident.simulation.replica import Repeat

_PASSES = 0.15  # of the Nyquist frequency, at most
_BEYOND = 3.0  # times the frequency that the fastest coordinate reaches over its encoder's noise


def driven(robot: Robot) -> bool:
    """Whether its file says what drives its joints."""
    return robot.controller is not None or robot.servo is not None


def smoothed(robot: Robot, again: Repeat) -> Repeat:
    """The same with inputs in which there is little noise; `robot` is fitted."""
    from scipy.signal import butter

    plan, log = again.plan, again.log
    torques = [torque_of(k) for k, _ in robot.numbered]
    logged, measured = log.signals(torques), log.signals(robot.coordinates)
    corner = min(_PASSES, _BEYOND * max(all_reached(measured)))
    sections = np.asarray(butter(4, corner, output="sos"))
    q = without_phase(sections, measured)
    dq, ddq = (np.gradient(x, log.period, axis=0) for x in (q, np.gradient(q, log.period, axis=0)))
    motion = Motion(q, dq, ddq, without_phase(sections, logged), plan.time)
    p = np.array(list(robot.linear_parameters.values()))
    needed = without_phase(sections, generalised_forces(robot, motion, p)[:, : len(torques)])
    reference, held = without_phase(sections, plan.reference), logged - plan.feedforward
    return replace(again, plan=replace(plan, reference=reference, feedforward=needed - held))
