"""The feed-forward torque behind a log: its column, or what the known controller does not account for.

A log with references and torques but without `tau_ff` still holds the feed-forward: the law of the controller
is known, so tau_ff = tau − PID(r − e), sample by sample. Taken as zero instead, the excitation would be lost.
What the integral held before the first sample is not in the log: there it carries the arm, as in the FMU,
and any other constant is part of the feed-forward.
"""

from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import feedforward_of
from flexmodels.robot import Robot
from flexmodels.settings.controller import Controller
from pyident.conditioning.motion import Motion
from pyident.logs.log import Log
from pyident.regression.machine.svd import svd
from pyident.regression.regressor import regressor

_LAGS = 8  # samples of error and torque from which the next ones are predicted
_OFF = 0.25  # of the controller's own gain: a plant's nonlinearity alone leaves a tenth or so
_CERTAIN = 4.0  # standard deviations
_ROUNDING = 1e-9  # of the error's rms: what is predicted better holds no noise, and nothing can be told
_SAME_RATE = 1e-3


@dataclass(frozen=True)
class Misfit:
    """A joint whose torque does not answer the position as the robot's controller would.

    percent   by which the answer to an error differs from the controller's
    """

    joint: int
    percent: float

    @property
    def sentence(self) -> str:
        return (
            f"the [controller] of the robot file does not fit joint {self.joint}: the torque answers a "
            f"change of the position {self.percent:.0f} % differently"
        )


def controller_torque(controller: Controller, reference: np.ndarray, e: np.ndarray) -> np.ndarray:
    """(N, joints) what the digital PID makes of reference and position (N, joints); its integral starts at 0.

    The derivative is 0 at the first sample, and the integral takes the errors from the second on.
    """
    Kp, Kd, Ki = (np.array(gain) for gain in (controller.Kp, controller.Kd, controller.Ki))
    error = reference - e
    slope = np.diff(error, axis=0, prepend=error[:1]) / controller.period
    integral = controller.period * (np.cumsum(error, axis=0) - error[0])
    return Kp * error + Kd * slope + Ki * integral


def feedforward(robot: Robot, log: Log, speed: np.ndarray) -> np.ndarray:
    """(N, joints) feed-forward torques [N m or N]: the log's columns, and what they lack recovered.

    robot   with the parameters under which the log will be simulated: they tell what carries it at the start
    speed   (joints,) at which its simulation enters the log
    The log has references; `recoverable` tells whether what is recovered can be relied on.
    """
    names = [feedforward_of(k) for k, _ in robot.numbered]
    given = log.frame.reindex(columns=names).to_numpy(dtype=float, copy=True)
    missing = [name not in log.frame for name in names]
    if any(missing) and robot.controller is not None:
        reference, e, tau = (_of_joints(robot, log, s) for s in ("r", "e", "tau"))
        rest = tau - controller_torque(robot.controller, reference, e) - carrying_torque(robot, log, speed)
        given[:, missing] = rest[:, missing]
    return given


def recoverable(robot: Robot, log: Log) -> bool:
    """Whether the log's torques are samples of this controller, one per period."""
    controller = robot.controller
    return controller is not None and abs(log.period * controller.rate - 1) < _SAME_RATE


def misfits(robot: Robot, log: Log) -> list[Misfit]:
    """Joints without a `tau_ff` column where the log speaks against the robot's controller.

    The noise of an encoder that nothing before it predicts reaches the torque of the same sample through the
    controller alone: the plant answers later. So the part of the recovered feed-forward that goes with it is
    zero for the right gains, whatever the feed-forward is. Without noise nothing can be told, nor need be.
    """
    assert robot.controller is not None
    listed = []
    for k, _ in robot.numbered:
        if feedforward_of(k) in log.frame:
            continue
        r, e, tau = (log.frame[f"joint{k}.{s}"].to_numpy(dtype=float) for s in ("r", "e", "tau"))
        gain, std = _answer(r, r - e, tau)
        own = (
            robot.controller.Kp[k - 1]
            + robot.controller.Kd[k - 1] * robot.controller.rate
            + robot.controller.Ki[k - 1] * robot.controller.period
        )
        deviation = abs(gain - own)
        if deviation > max(_CERTAIN * std, _OFF * abs(own)):
            listed.append(Misfit(k, 100 * deviation / max(abs(own), 1e-300)))
    return listed


def carrying_torque(robot: Robot, log: Log, speed: np.ndarray) -> np.ndarray:
    """(joints,) torques of a steady motion where the log starts, by the robot's own parameters."""
    return carrying_rows(robot, log, speed) @ np.array(list(robot.linear_parameters.values()))


def carrying_rows(robot: Robot, log: Log, speed: np.ndarray) -> np.ndarray:
    """(joints, P) of these torques: rows of the regressor."""
    q, joints = log.signals(robot.coordinates)[:1], len(robot.joints)
    dq = np.zeros_like(q)
    dq[0, :joints] = speed
    steady = Motion(q, dq, 0 * q, np.zeros((1, joints)), np.zeros(1))
    return regressor(robot, steady).matrix[0, :joints]


def _answer(r: np.ndarray, error: np.ndarray, tau: np.ndarray) -> tuple[float, float]:
    """Gain from an error that the past does not predict to the torque of the same sample, and its std."""
    rows = np.arange(_LAGS, len(r))
    past = [x[rows - lag] for lag in range(1, _LAGS + 1) for x in (error, tau)]
    known = np.column_stack([*past, *(r[rows - lag] for lag in range(3)), np.ones(len(rows))])
    scale = np.maximum(np.linalg.norm(known, axis=0), 1e-300)
    U, s, _ = svd(known / scale)
    U = U[:, s > _ROUNDING * s[0]]
    new = error[rows] - U @ (U.T @ error[rows])
    answer = tau[rows] - U @ (U.T @ tau[rows])
    energy = float(new @ new)
    if energy <= (_ROUNDING * np.linalg.norm(error[rows])) ** 2:
        return np.nan, np.inf
    gain = float(new @ answer) / energy
    left = answer - gain * new
    return gain, float(np.sqrt(left @ left / max(len(rows) - U.shape[1] - 1, 1) / energy))


def _of_joints(robot: Robot, log: Log, signal: str) -> np.ndarray:
    return log.signals([f"joint{k}.{signal}" for k, _ in robot.numbered])
