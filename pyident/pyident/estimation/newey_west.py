"""The long-run covariance of Newey and West (1987), gathered block by block.

Bartlett's weights 1 − l/(L+1) are those of a box with itself, so the weighted sum of all lagged products
is that of plain squares of box sums: Σ bₜ bₜᵀ / (L+1) with bₜ = sₜ + sₜ₋₁ + … + sₜ₋L.
"""

import numpy as np


class LongRun:
    """The sum over lags up to L of the weighted products of scores s (P,), zero before and after."""

    def __init__(self, size: int, lags: int):
        self.lags = lags
        self.last = np.zeros((lags, size))
        self.squares = np.zeros((size, size))

    def add(self, scores: np.ndarray) -> None:
        """The next scores (B, P)."""
        self.squares += self._squares(scores)
        self.last = np.concatenate([self.last, scores])[len(scores) :]

    @property
    def sum(self) -> np.ndarray:
        """(P, P) of all scores so far."""
        return (self.squares + self._squares(np.zeros_like(self.last))) / (self.lags + 1)

    def _squares(self, scores: np.ndarray) -> np.ndarray:
        sums = np.cumsum(np.concatenate([np.zeros((1, scores.shape[1])), self.last, scores]), axis=0)
        boxes = sums[self.lags + 1 :] - sums[: -self.lags - 1]
        return boxes.T @ boxes
