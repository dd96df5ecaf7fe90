"""The motion whose base regressor has the smallest condition number, by gradients, limits as constraints.

The largest and the smallest singular value are replaced by smooth ones, by norms of a high order of all of
them and of their inverses. Constraints are the worst samples of every limit, one per part of the motion.
Sequential quadratic programming climbs from one random motion after the other until the budget is spent. Each
of them keeps the limits when it sets out, and the best that keeps them is returned.

Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28, 1988, in SciPy; the criterion:
Gautier and Khalil, Exciting trajectories for the identification of base inertial parameters, 1992.
"""

import time
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.optimize import minimize

from pyident.excitation.gradients.slopes import Setting
from pyident.excitation.search import Best, Budget, Progress

_ORDER = 8.0  # of the norms: higher is nearer to the true condition number, and less smooth
_PARTS = 12  # of a motion, of each of which the worst sample is kept within a limit
_SLACK = 1e-3  # of a limit, beyond which a motion does not count
_ENOUGH = 1e-4  # of the logarithm: a climb that gains less in a step has arrived


def condition_number(matrix: np.ndarray) -> float:
    """Of equations (N, n, R); inf without full rank."""
    s = _singular(matrix)[0]
    return float(s[0] / s[-1]) if s[-1] > 0 else np.inf


def smallest_condition(
    setting: Setting, starts: Sequence[np.ndarray], budget: Budget, progress: Progress | None = None
) -> Best:
    """Coefficients of the family as x, minus the logarithm of their condition number as score.

    starts   coefficients (joints, M) of motions that keep the limits
    A derivative costs as many evaluations as it takes motions; at least one motion is judged. A
    KeyboardInterrupt ends the search with the best so far.
    """
    search = _Search(setting, starts[0].shape, budget, progress or (lambda _: None))
    try:
        order = sorted(starts, key=search.offered)
        for start in order:
            search.climb(start)
    except _Spent:
        pass
    except KeyboardInterrupt:
        if search.best.x.size == 0:
            raise
        return Best(search.best.x, search.best.score, search.evaluations, True)
    return Best(search.best.x, search.best.score, search.evaluations, False)


class _Spent(Exception):
    pass


class _Search:
    """What has been found so far, and what it has cost."""

    def __init__(self, setting: Setting, shape: tuple[int, ...], budget: Budget, progress: Progress):
        self.setting, self.shape, self.budget, self.progress = setting, shape, budget, progress
        self.best, self.evaluations, self.begun = Best(np.array([]), -np.inf, 0, False), 0, time.monotonic()
        self._point: _Point | None = None

    def offered(self, start: np.ndarray) -> float:
        """Logarithm of a start's condition number; one that keeps the limits by construction counts."""
        if self.best.x.size:
            self.spend(0)
        return -self._kept(_Point(self, start.ravel()))

    def climb(self, start: np.ndarray) -> None:
        limits = {"type": "ineq", "fun": lambda x: self.at(x).left, "jac": lambda x: self.at(x).left_slopes}
        minimize(
            lambda x: self.at(x).smooth,
            start.ravel(),
            jac=lambda x: self.at(x).smooth_slopes,
            method="SLSQP",
            constraints=[limits],
            options={"maxiter": self.budget.evaluations, "ftol": _ENOUGH},
        )

    def at(self, x: np.ndarray) -> "_Point":
        if self._point is None or not np.array_equal(self._point.x, x):
            self._point = _Point(self, x.copy())
            if self._point.left.min() >= -_SLACK:
                self._kept(self._point)
        return self._point

    def spend(self, motions: int) -> None:
        """Raises _Spent where the budget is."""
        self.evaluations += motions
        passed = time.monotonic() - self.begun
        spent = max(self.evaluations / self.budget.evaluations, passed / self.budget.seconds)
        self.progress(min(spent, 1.0))
        if spent >= 1:
            raise _Spent

    def _kept(self, point: "_Point") -> float:
        score = -float(np.log(condition_number(point.samples.matrix)))
        if score > self.best.score or not self.best.x.size:
            self.best = Best(point.x.reshape(self.shape), score, self.evaluations, False)
        return score


class _Point:
    """A motion by its coefficients, its derivatives only where they are asked for."""

    def __init__(self, search: _Search, x: np.ndarray):
        self.search, self.setting, self.x = search, search.setting, x
        self.motion = self.setting.motion(x.reshape(search.shape))
        if search.best.x.size:
            search.spend(1)
        self.samples = self.setting.samples(self.motion)
        parts = np.array_split(np.arange(len(self.samples.left)), _PARTS)
        worst = [part[np.argmin(self.samples.left[part], axis=0)] for part in parts]
        self._worst = np.array(worst), np.arange(self.samples.left.shape[1])

    @property
    def left(self) -> np.ndarray:
        """(parts x L,) the least that is left of every limit in every part."""
        return self.samples.left[self._worst].ravel()

    @cached_property
    def smooth(self) -> float:
        """Logarithm of the smooth condition number."""
        s = np.log(np.maximum(self._spectrum[0], 1e-300))
        largest = s[0] + np.log(np.sum(np.exp(_ORDER * (s - s[0])))) / _ORDER
        return float(largest - s[-1] + np.log(np.sum(np.exp(_ORDER * (s[-1] - s)))) / _ORDER)

    @property
    def smooth_slopes(self) -> np.ndarray:
        return self._slopes[0]

    @property
    def left_slopes(self) -> np.ndarray:
        return self._slopes[1]

    @cached_property
    def _spectrum(self) -> tuple[np.ndarray, np.ndarray]:
        return _singular(self.samples.matrix)

    @cached_property
    def _slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """Of `smooth` (coefficients,) and of `left` (parts x L, coefficients)."""
        s, Vt = self._spectrum
        high, low = (s / s[0]) ** _ORDER, (s[-1] / s) ** _ORDER
        weight = (high / high.sum() - low / low.sum()) / s**2
        per_entry = self.samples.matrix @ ((Vt.T * weight) @ Vt)  # d smooth / d matrix
        basis, (at, limit) = self.setting.basis, self._worst
        shape = self.search.shape
        smooth, left = np.zeros(shape), np.zeros((at.size, *shape))
        self.search.spend(3 * shape[0])
        for i, k, change in self.setting.slopes(self.motion):
            smooth[k] += np.einsum("nrp,nrp->n", per_entry, change.matrix) @ basis[i]
            left[:, k] += change.left[at, limit].reshape(-1, 1) * basis[i][at.ravel()]
        return smooth.ravel(), left.reshape(len(left), -1)


def _singular(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Singular values of equations (N, n, R), largest first, and the directions (R, R) as rows."""
    triangle = np.linalg.qr(matrix.reshape(-1, matrix.shape[2]), mode="r")
    return np.linalg.svd(triangle)[1:]
