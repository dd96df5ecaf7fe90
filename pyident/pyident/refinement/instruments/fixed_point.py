"""Steps towards p = g(p) when each g(p) is dear: Newton's, with Broyden's corrections (1965)."""

import numpy as np

_LONGER = 2.0  # times the step without corrections: they were made by what sticks, not by a slope


class FixedPoint:
    """Steps of p (P,) from the gaps g(p) - p; gaps must be asked for in turn, each after the step before it.

    Where joints stick and break away, g(p) jumps a little: two gaps that are nearly alike would be taken for
    a flat slope, and the step that such a correction asks for goes far astray. Corrections that lengthen a
    step more than twofold are forgotten, all of them.

    jacobian   (P, P) of p - g(p), where the steps begin
    spread     (P,) by which changes of single parameters are compared; infinite where they do not count
    """

    def __init__(self, jacobian: np.ndarray, spread: np.ndarray):
        self._first = self._jacobian = jacobian
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
        made, plain = np.linalg.solve(self._jacobian, gap), np.linalg.solve(self._first, gap)
        if self._length(made) > _LONGER * self._length(plain):
            self._jacobian, made = self._first, plain
        self._last = made, gap
        return made

    def went(self, share: float) -> None:
        """Only a share of the last step was gone."""
        if self._last is not None:
            made, gap = self._last
            self._last = share * made, gap

    def _length(self, step: np.ndarray) -> float:
        return float(np.sqrt(self._weights @ step**2))
