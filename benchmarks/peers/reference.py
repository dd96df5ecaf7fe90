"""The yardstick: DOP853 at 1e-11 with every reversal and every release of a stuck joint located."""

from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from flexmodels.mechanics.plant import Equations

_AT_REST = 1e-13  # rad/s by which a joint may have overshot the reversal


class EventExact:
    """The robot's own equations with a mode per motor hinge: +1 slides forward, -1 backward, 0 is stuck."""

    def __init__(self, equations: Equations):
        self.eq, self.n = equations, len(equations.coordinates)
        self.p = np.array(list(equations.parameters.values()))
        self.reset(np.zeros(self.n))

    def reset(self, q: np.ndarray) -> None:
        self.x, self.mode = np.r_[q, np.zeros(self.n)], np.zeros(self.eq.joints)

    def angles(self) -> np.ndarray:
        return self.x[: self.eq.joints]

    def tip(self) -> np.ndarray:
        return np.array(self.eq.tip(self.x)).ravel()

    def advance(self, torque: np.ndarray) -> None:
        assert self.eq.controller is not None
        t, period = 0.0, self.eq.controller.period
        self._release(torque)
        while t < period:
            events = [partial(self._margin, u=torque, joint=j) for j in range(self.eq.joints)]
            for event in events:
                event.terminal, event.direction = True, -1  # pyright: ignore
            done = solve_ivp(
                lambda _, x: self._rates(x, torque)[0],
                (t, period),
                self.x,
                "DOP853",
                rtol=1e-11,
                atol=1e-13,
                events=events,
            )
            t, self.x = done.t[-1], done.y[:, -1]
            for j, times in enumerate(done.t_events):
                if len(times) and self.mode[j] != 0:
                    self.mode[j] = self.x[self.n + j] = 0.0
            self._release(torque)

    def _rates(self, x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of the state; and the reaction of the stuck joints."""
        dx, reaction, _ = self.eq.rates(x, u, self.p, self.mode)
        return np.array(dx).ravel(), np.array(reaction).ravel()

    def _margin(self, _: float, x: np.ndarray, u: np.ndarray, joint: int) -> float:
        """How far a joint is from leaving its mode."""
        if self.mode[joint]:
            return self.mode[joint] * x[self.n + joint] + _AT_REST
        return self._hold(x, u)[joint] + _AT_REST

    def _hold(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        upper, lower = (np.array(v).ravel() for v in self.eq.breakaway(x, u, self.p))
        _, reaction = self._rates(x, u)
        return np.minimum(upper - reaction, reaction - lower)

    def _release(self, u: np.ndarray) -> None:
        """Let go of the most overloaded stuck joint until none is."""
        for _ in range(self.eq.joints + 1):
            hold = np.where(self.mode == 0, self._hold(self.x, u), np.inf)
            worst = int(np.argmin(hold))
            if hold[worst] >= 0:
                return
            self.mode[worst] = np.sign(self._rates(self.x, u)[1][worst])
