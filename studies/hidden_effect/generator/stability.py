"""Whether an arm's sampled loop is stable: the linear loop at rest, in several poses."""

import casadi as ca
import numpy as np
from scipy.linalg import expm

from flexmodels.robot import Robot

from . import model


class LinearLoop:
    """The linear sampled loop of a robot, without dry friction, for any values of its parameters.

    Raises ValueError for a robot without controller.
    """

    def __init__(self, robot: Robot):
        if robot.controller is None:
            raise ValueError(f"robot {robot.name} has no [controller]; add one")
        self.control, arm = robot.controller, model.Arm(robot)
        self.joints, n = arm.joints, len(arm.names)
        self.size = 2 * n
        x, rates = ca.vertcat(arm.q, arm.v), ca.substitute(model.rates(arm), arm.t, 0)
        jacobians = [ca.jacobian(rates, x), ca.jacobian(rates, arm.u)]
        self._slopes = ca.Function("slopes", [x, arm.u, arm.p], [ca.cse(j) for j in jacobians])
        self._names = list(arm.numbers)

    def slowest_decay(self, robot: Robot, poses: np.ndarray) -> float:
        """Largest magnitude of an eigenvalue per controller period over poses (P, joints) [rad]."""
        p = [0.0 if n.endswith(".coulomb") else robot.parameters[n] for n in self._names]
        return max(float(np.abs(np.linalg.eigvals(self._loop(p, pose))).max()) for pose in poses)

    def _loop(self, p: list[float], pose: np.ndarray) -> np.ndarray:
        """Next (x, measured e, integral) from this one, about rest; the torque is held over the period."""
        n, m, h = self.size, self.joints, self.control.period
        state = np.zeros(n)
        state[:m] = pose
        A, B = (np.array(value) for value in self._slopes(state, np.zeros(m), p))
        both = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * h)
        e = np.eye(m, n)
        Kp, Kd, Ki = (np.diag(gains) for gains in (self.control.Kp, self.control.Kd, self.control.Ki))
        torque = np.hstack([-(Kp + Kd / h + h * Ki) @ e, Kd / h, np.eye(m)])
        loop = np.zeros((n + 2 * m, n + 2 * m))
        loop[:n, :n] = both[:n, :n]
        loop[:n] += both[:n, n:] @ torque
        loop[n : n + m, :n] = e
        loop[n + m :, :n], loop[n + m :, n + m :] = -h * Ki @ e, np.eye(m)
        return loop
