"""Torques along a motion by Pinocchio, and what of a force the bodies and usual frictions cannot imitate."""

import numpy as np

from ..rigid_arm.pinocchio_chain import chain, inverse_dynamics, pinocchio
from .laws import State
from .machines import Machine

_MOST = 1500  # samples that a force is compared on


class Oracle:
    """Of a machine, which must not change. Needs the package `pin`."""

    def __init__(self, machine: Machine):
        self.machine, self.model = machine, chain(machine.robot)

    def state(self, time: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> State:
        """With the loads along positions, speeds, accelerations (N, n)."""
        return State(time, q, v, inverse_dynamics(self.model, q, v, a))

    def plain(self, state: State, a: np.ndarray) -> np.ndarray:
        """(N, n) torques with nothing hidden."""
        m = self.machine
        return state.load + m.rotor * a + m.coulomb * np.sign(state.v) + m.viscous * state.v

    def beyond(self, state: State, a: np.ndarray, force: np.ndarray) -> np.ndarray:
        """(N', n): what a least squares of all bodies and usual frictions leaves of a force (N, n)."""
        every = slice(None, None, max(1, len(a) // _MOST))
        q, v, a, force = state.q[every], state.v[every], a[every], force[every]
        pin, data, n = pinocchio(), self.model.createData(), force.shape[1]
        rows = zip(q, v, a, strict=True)
        bodies = [pin.computeJointTorqueRegressor(self.model, data, *row) for row in rows]
        own = np.zeros((len(a), n, 4 * n))
        for k in range(n):
            usual = (a[:, k], np.sign(v[:, k]), v[:, k], np.ones(len(a)))
            own[:, k, 4 * k : 4 * k + 4] = np.column_stack(usual)
        bodies = np.reshape(bodies, (len(a), n, 10 * n))  # Pinocchio gives a single joint's as a vector
        A = np.concatenate([bodies, own], axis=2).reshape(len(a) * n, -1)
        scale = np.maximum(np.linalg.norm(A, axis=0), 1e-9)
        p, *_ = np.linalg.lstsq(A / scale, force.ravel(), rcond=1e-9)
        return force - (A / scale @ p).reshape(force.shape)
