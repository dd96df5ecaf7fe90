"""Instruments where nothing says how the torque of the logs was made.

A controller stands in that follows the measured motion and is fed the measured torque. Both go without their
highest frequencies, as their noise would pass into the instruments. It holds its torque between samples and
the log's was not held, so that what its equations leave says nothing of the log's.
"""

from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.filters import without_phase
from pyident.simulation.replica import Repeat

_PASSES = 0.15  # of the Nyquist frequency


def driven(robot: Robot) -> bool:
    """Whether its file says what drives its joints."""
    return robot.controller is not None or robot.servo is not None


def smoothed(again: Repeat) -> Repeat:
    """The same with inputs in which there is little noise."""
    from scipy.signal import butter

    sections, plan = np.asarray(butter(4, _PASSES, output="sos")), again.plan
    reference, feedforward = (without_phase(sections, x) for x in (plan.reference, plan.feedforward))
    return replace(again, plan=replace(plan, reference=reference, feedforward=feedforward))
