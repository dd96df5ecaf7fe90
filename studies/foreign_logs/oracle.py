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
        A, force = self._imitating(state, a), force[_every(a)]
        return force - _imitated(A.reshape(force.size, -1), force.ravel()).reshape(force.shape)

    def deviations(self, state: State, a: np.ndarray, force: np.ndarray, power: np.ndarray) -> float:
        """Standard deviations from zero at which the best of all estimates finds a force (N, n).

        power   of the torques' noise, (frequencies, n);  bodies and usual frictions are unknown
        By generalised least squares: what these imitate counts in units of the noise, joint by joint and
        frequency by frequency.
        """
        A, force = self._imitating(state, a), force[_every(a)]
        n, bins = force.shape[1], len(force) // 2 + 1
        size = np.sqrt(power[:bins, :, None] * len(force) ** 2 / (2 * len(a)))  # half of it: of f > 0
        white = np.fft.rfft(np.concatenate([A, force[:, :, None]], axis=2), axis=0) / size
        white = np.concatenate([white.real, white.imag]).reshape(2 * bins * n, -1)
        return float(np.linalg.norm(white[:, -1] - _imitated(white[:, :-1], white[:, -1])))

    def _imitating(self, state: State, a: np.ndarray) -> np.ndarray:
        """(N', n, P) columns of all bodies and usual frictions."""
        every = _every(a)
        q, v, a = state.q[every], state.v[every], a[every]
        pin, data, n = pinocchio(), self.model.createData(), a.shape[1]
        rows = zip(q, v, a, strict=True)
        bodies = [pin.computeJointTorqueRegressor(self.model, data, *row) for row in rows]
        own = np.zeros((len(a), n, 4 * n))
        for k in range(n):
            usual = (a[:, k], np.sign(v[:, k]), v[:, k], np.ones(len(a)))
            own[:, k, 4 * k : 4 * k + 4] = np.column_stack(usual)
        bodies = np.reshape(bodies, (len(a), n, 10 * n))  # Pinocchio gives a single joint's as a vector
        return np.concatenate([bodies, own], axis=2)


def _every(a: np.ndarray) -> slice:
    """The samples of (N, n) that a force is compared on."""
    return slice(None, None, max(1, len(a) // _MOST))


def _imitated(A: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Least squares of the columns of A."""
    scale = np.maximum(np.linalg.norm(A, axis=0), 1e-9)
    p, *_ = np.linalg.lstsq(A / scale, y, rcond=1e-9)
    return A / scale @ p
