"""From logged signals to what the regression needs: q and its derivatives, torques at the same instants."""

from dataclasses import dataclass

import numpy as np
from flexmodels.robot import Processing, Robot
from scipy.signal import butter, cheby1, sosfiltfilt

from pyident.log import Log, LogError, require
from pyident.regressor import Motion

# Central differences of eighth order (Khan and Ohba 2003), halves: offsets 1 to 4.
_FIRST = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
_SECOND = np.array([8 / 5, -1 / 5, 8 / 315, -1 / 560])
_CENTRE = -205 / 72
_REACH = len(_FIRST)
_SETTLING = 50  # samples that a zero-phase filter's ends may spoil


@dataclass(frozen=True)
class Conditioned:
    """Samples ready for the regression.

    motion   q, dq, ddq and torque, (N, n) and (N, joints)
    target   right-hand side of eq. (9): torques over zeros, (N, n)
    thinning filter and factor applied to regressor and target alike (1: none)
    """

    motion: Motion
    target: np.ndarray
    thinning: int


def condition(log: Log, robot: Robot) -> Conditioned:
    """Differentiate the coordinates and align the torques, as the robot's [processing] says.

    A held torque (the robot has a digital controller) acts from its sample to the next one; the
    acceleration at a sample lies between the torques before and after it, so their mean is taken.
    Raises LogError.
    """
    plan = robot.processing
    require(log, robot, _needed(plan, len(robot.parameters)))
    q = log.signals(robot.coordinates)
    torque = log.signals([f"joint{k}.tau" for k, _ in robot.numbered])
    if plan.cutoff is not None:
        q = _low_pass(q, plan, log)
    if robot.controller is not None:
        torque[1:] = (torque[1:] + torque[:-1]) / 2
    q, dq, ddq = derivatives(q, log.period)
    border = _SETTLING if plan.cutoff is not None else 0
    keep = slice(border, len(q) - border)
    time = log.signals(["time"])[_REACH:-_REACH, 0]
    motion = Motion(q[keep], dq[keep], ddq[keep], torque[_REACH:-_REACH][keep], time[keep])
    target = np.zeros_like(motion.q)
    target[:, : len(robot.joints)] = motion.tau
    return Conditioned(motion, target, plan.decimate)


def derivatives(q: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, dq, ddq by eighth-order central differences; four samples are lost at either end.

    q (N, n) -> three arrays (N - 8, n).
    """
    n = len(q) - 2 * _REACH
    inner = q[_REACH : _REACH + n]
    dq, ddq = np.zeros_like(inner), _CENTRE * inner
    for i, (first, second) in enumerate(zip(_FIRST, _SECOND, strict=True), start=1):
        ahead, behind = q[_REACH + i : _REACH + i + n], q[_REACH - i : _REACH - i + n]
        dq += first * (ahead - behind)
        ddq += second * (ahead + behind)
    return inner, dq / period, ddq / period**2


def thin(columns: np.ndarray, factor: int) -> np.ndarray:
    """Low-pass and keep every `factor`-th sample, along the first axis and without phase shift."""
    if factor == 1:
        return columns
    sections = np.asarray(cheby1(8, 0.05, 0.8 / factor, output="sos"))
    return sosfiltfilt(sections, columns, axis=0)[::factor]


def _low_pass(q: np.ndarray, plan: Processing, log: Log) -> np.ndarray:
    nyquist = 0.5 / log.period
    assert plan.cutoff is not None
    if plan.cutoff >= nyquist:
        raise LogError(
            f"{log.source}: the cutoff of {plan.cutoff:g} Hz needs more than {2 * plan.cutoff:g} samples a "
            f"second, the log has {2 * nyquist:g}; lower processing.cutoff in the robot file"
        )
    sections = np.asarray(butter(plan.order, plan.cutoff / nyquist, output="sos"))
    return sosfiltfilt(sections, q, axis=0)


def _needed(plan: Processing, parameters: int) -> int:
    """Samples without which the equations cannot be more than the unknowns."""
    border = 2 * _REACH + (2 * _SETTLING if plan.cutoff is not None else 0)
    return border + max(50, 2 * parameters) * plan.decimate
