"""Steps towards p = g(p) when each g(p) is dear: Newton's, with Broyden's corrections (1965)."""

import numpy as np


class FixedPoint:
    """Steps of p (P,) from the gaps g(p) - p; gaps must be asked for in turn, each after the step before it.

    jacobian   (P, P) of p - g(p), where the steps begin
    spread     (P,) by which changes of single parameters are compared; infinite where they do not count
    """

    def __init__(self, jacobian: np.ndarray, spread: np.ndarray):
        self._jacobian = jacobian
        self._weights = np.where(np.isfinite(spread) & (spread > 0), spread, np.inf) ** -2.0
        self._last: tuple[np.ndarray, np.ndarray] | None = None

    def step(self, gap: np.ndarray) -> np.ndarray:
        """(P,) from p towards the fixed point."""
        if self._last is not None:
            step, before = self._last
            row = self._weights * step
            if row @ step > 0:
                missed = before - gap - self._jacobian @ step
                self._jacobian = self._jacobian + np.outer(missed, row) / (row @ step)
        made = np.linalg.solve(self._jacobian, gap)
        self._last = made, gap
        return made
