"""A motion at its samples: the regressor and what is left of every limit, with their derivatives.

At a sample both depend on nothing but position, speed and acceleration of the joints there. Three changes per
joint, made at all samples at once, give the derivatives with respect to any number of coefficients.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from flexmodels.coordinate import motor_of
from pyident.excitation.capsules import clearances
from pyident.excitation.drawing import Drawing
from pyident.excitation.followed import followed
from pyident.regression.regressor import regressor

_CHANGE = 1e-6  # rad, rad/s, rad/s2, or with m: of one joint, for the derivatives
_ASIDE = 0.1  # of their radius, that links keep apart at the samples: they may come nearer in between


@dataclass(frozen=True)
class Samples:
    """Of N samples. matrix (N, n, R): columns of Φ; left (N, L): shares of limits, negative beyond them."""

    matrix: np.ndarray
    left: np.ndarray


@dataclass(frozen=True)
class Setting:
    """Where motions are judged: limits of a drawing, times (N,) [s], columns (R,) of Φ."""

    drawing: Drawing
    time: np.ndarray
    columns: np.ndarray

    @cached_property
    def basis(self) -> np.ndarray:
        """(3, N, coefficients of a joint)."""
        return self.drawing.family.basis(self.time)

    def motion(self, coefficients: np.ndarray) -> np.ndarray:
        """(3, N, joints) q, dq, ddq of coefficients (joints, coefficients of a joint)."""
        out = self.basis @ coefficients.T
        out[0] += self.drawing.family.limits.home
        return out

    def samples(self, motion: np.ndarray) -> Samples:
        """Of q, dq, ddq (3, N, joints)."""
        return self._at(motion, self._apart(motion[0]))

    def slopes(self, motion: np.ndarray) -> Iterator[tuple[int, int, Samples]]:
        """(derivative, joint, change of the samples per unit) of each of q, dq, ddq and each joint."""
        apart = self._apart(motion[0])
        here = self._at(motion, apart)
        for i, k in np.ndindex(3, motion.shape[2]):
            changed = motion.copy()
            changed[i, :, k] += _CHANGE
            there = self._at(changed, self._apart(changed[0]) if i == 0 else apart)
            yield (
                i,
                k,
                Samples((there.matrix - here.matrix) / _CHANGE, (there.left - here.left) / _CHANGE),
            )

    def _at(self, motion: np.ndarray, apart: np.ndarray) -> Samples:
        robot, limits = self.drawing.task.robot, self.drawing.family.limits
        q, dq, ddq = motion
        along = followed(robot, self.time, q, dq, ddq)
        Phi = regressor(robot, along).matrix
        p = np.array(list(robot.linear_parameters.values()))
        tau = (Phi @ p)[:, : len(robot.joints)]
        half = (limits.upper - limits.lower) / 2
        left = [(limits.upper - q) / half, (q - limits.lower) / half]
        for values, most in ((dq, limits.speed), (ddq, limits.acceleration), (tau, self.drawing.torque)):
            limited = np.isfinite(most)
            left.append(1 - np.abs(values[:, limited]) / most[limited])
        return Samples(Phi[:, :, self.columns], np.hstack([*left, apart]))

    def _apart(self, q: np.ndarray) -> np.ndarray:
        """(N, pairs) distances of links beyond those that are kept, over their radius."""
        task = self.drawing.task
        frame = pd.DataFrame(q, columns=[motor_of(k) for k, _ in task.robot.numbered])
        near = [of.distance - of.least for of in clearances(task.geometry, frame)]
        return np.reshape(near, (len(near), len(q))).T / task.geometry.radius - _ASIDE
