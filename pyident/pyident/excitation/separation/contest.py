"""What logs of two rivals would decide: each runs the motion with its sensors' noise, and both are refitted.

A log of one rival is fitted by the equations without either law, and by these with the columns of each: all
linear parameters within the laws' bounds, nonlinear ones over their grid. The level of an equation at a
frequency is what the rival's own parameters leave there, over several logs: noise on its way through the
loop, the differences and the friction, and what the equations of a law that is not smooth leave besides.
In these units the wrong rival leaves a sum of squares that is larger than the right one's by the square of
their distance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.fading import faded
from pyident.conditioning.weak_form import condition
from pyident.excitation.rehearsals.rehearsal import Rehearsal
from pyident.excitation.separation.rivals import Rivals, Suspect, law_values
from pyident.logs.log import Log
from pyident.regression.candidate_columns import effect_columns, nonlinear_grid
from pyident.regression.spectrum import Equations, equations, floor

_CUT = 1e-10  # of the largest eigenvalue of a scaled Gram matrix: below is arithmetic
_LAW_CUT = 1e-9  # of a column's energy: less, and the other columns imitate it


@dataclass(frozen=True)
class Contest:
    """The rivals, who runs for each of them, and channel -> standard deviation of its sensor."""

    rivals: Rivals
    rehearsals: Sequence[Rehearsal]
    noise: Mapping[str, float]

    def sigmas(self, plan: Experiment, seeds: Sequence[int]) -> float:
        """The closer of the two ways round of a plan; 0 where one of them cannot run it."""
        sides = [i for i, who in enumerate(self.rivals.suspects) if who is not None]
        try:
            falls = [self.falls(i, self.rehearsals[i].noisy(plan, self.noise, seeds)) for i in sides]
        except SimulationError:
            return 0.0
        return float(np.sqrt(max(min(np.mean(fall) for fall in falls), 0.0)))

    def falls(self, own: int, logs: Sequence[Log]) -> np.ndarray:
        """(logs,) how much more of the logs of rival `own` the other one leaves."""
        found = [_Fit.of(self.rivals, log) for log in logs]
        left = [fit.left_by(self.rivals, own) for fit in found]
        level = floor([fit.asked.band for fit in found], left)
        out = []
        for fit in found:
            whitened = fit.over(level.at(fit.asked.band))
            right, wrong = (whitened.least(self.rivals, side, side == own) for side in (own, 1 - own))
            out.append(wrong - right)
        return np.array(out)


@dataclass(frozen=True)
class _Fit:
    """A log's equations without either law, each divided by level (n, E)."""

    asked: Equations
    level: np.ndarray
    basis: np.ndarray
    rest: np.ndarray

    @classmethod
    def of(cls, rivals: Rivals, log: Log) -> "_Fit":
        asked = equations(rivals.base, [faded(condition(log, rivals.base))], [log.period])[0]
        return cls(asked, np.ones_like(asked.y), np.zeros((asked.y.size, 0)), asked.y.ravel())

    def over(self, level: np.ndarray) -> "_Fit":
        """With an orthonormal basis of what the base imitates, and what it leaves of the forces."""
        whitened = self.asked.over(level)
        A = whitened.A.reshape(-1, whitened.A.shape[2])
        size = np.linalg.norm(A, axis=0)
        A = A[:, size > 0] / size[size > 0]
        w, V = np.linalg.eigh(A.T @ A)
        kept = w > _CUT * w[-1]
        basis = A @ (V[:, kept] / np.sqrt(w[kept]))
        y = whitened.y.ravel()
        return _Fit(self.asked, level, basis, y - basis @ (basis.T @ y))

    def left_by(self, rivals: Rivals, own: int) -> np.ndarray:
        """(n, E) of the measured forces less those of a rival's own parameters."""
        robot, who = rivals.robots[own], rivals.suspects[own]
        p = np.array([robot.parameters[name] for name in rivals.base.linear_parameters])
        left = self.asked.y - self.asked.A @ p
        if who is not None:
            linear, nonlinear = law_values(robot, who)
            left = left - self._columns(robot, who, nonlinear) @ np.array(list(linear.values()))
        return left

    def least(self, rivals: Rivals, side: int, true: bool) -> float:
        """Energy that a rival leaves; true: its own nonlinear values are known to be the right ones."""
        who = rivals.suspects[side]
        whole = float(self.rest @ self.rest)
        if who is None:
            return whole
        law = rivals.robots[side].joints[who.joint - 1].law(who.effect)
        own = law_values(rivals.robots[side], who)[1]
        grid = [] if true else nonlinear_grid(rivals.base, who.joint, who.effect, [self.asked.part.motion])
        bounds = np.array([p.lower for p in law.linear]), np.array([p.upper for p in law.linear])
        return whole - max(self._gain(rivals, who, values, bounds) for values in [*grid, own])

    def _gain(
        self, rivals: Rivals, who: Suspect, values: Mapping[str, float], bounds: tuple[np.ndarray, np.ndarray]
    ) -> float:
        X = (self._columns(rivals.base, who, values) / self.level[:, :, None]).reshape(len(self.rest), -1)
        size = np.linalg.norm(X, axis=0)
        X = X - self.basis @ (self.basis.T @ X)
        seen = np.linalg.norm(X, axis=0) > np.sqrt(_LAW_CUT) * size
        if not seen.any():
            return 0.0
        Q, R = np.linalg.qr(X[:, seen])
        y = Q.T @ self.rest
        found = lsq_linear(R, y, (bounds[0][seen], bounds[1][seen]))
        return float(y @ y - np.square(R @ found.x - y).sum())

    def _columns(self, robot: Robot, who: Suspect, values: Mapping[str, float]) -> np.ndarray:
        """(n, E, K) forces of a law's linear parameters, in the units of the equations."""
        part, band = self.asked.part, self.asked.band
        found = effect_columns(robot, who.joint, who.effect, part.motion, values)
        out = np.zeros((*self.asked.y.shape, len(found)))
        for k, rows in enumerate(found.values()):
            for row, force in rows.items():
                out[row, :, k] = band.transform(force * part.use[:, row])
        return out
