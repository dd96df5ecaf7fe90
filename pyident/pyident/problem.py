"""The regression of all logs, eq. (12), as blocks of equations that can be gone through again."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning import Conditioned, thin
from pyident.regressor import regressor, regressor_blocks

Block = tuple[np.ndarray, np.ndarray]  # A (B, n, P), y (B, n)


@dataclass(frozen=True)
class Problem:
    """A robot and its conditioned logs."""

    robot: Robot
    parts: tuple[Conditioned, ...]

    @property
    def rows(self) -> tuple[str, ...]:
        return self.robot.coordinates

    @property
    def columns(self) -> tuple[str, ...]:
        return tuple(self.robot.parameters)

    def blocks(self, weights: Sequence[np.ndarray] | None = None) -> Iterator[Block]:
        """Blocks of every log, one after the other; weights (N, n) per log multiply the equations."""
        for i, part in enumerate(self.parts):
            yield from _blocks(self.robot, part, None if weights is None else weights[i])

    def residuals(self, p: np.ndarray) -> list[np.ndarray]:
        """y − A p per log, (N, n)."""
        return [
            np.concatenate([y - A @ p for A, y in _blocks(self.robot, part, None)]) for part in self.parts
        ]


def _blocks(robot: Robot, part: Conditioned, weights: np.ndarray | None) -> Iterator[Block]:
    if part.thinning == 1:
        for at, Phi in regressor_blocks(robot, part.motion):
            use = part.use[at] if weights is None else part.use[at] * weights[at]
            for row in np.flatnonzero((use != 1).any(axis=0)):
                Phi[:, row] *= use[:, row, None]
            yield Phi, part.target[at] * use
    else:
        Phi, y = thin(regressor(robot, part.motion).matrix, part.thinning), thin(part.target, part.thinning)
        yield (Phi, y) if weights is None else (Phi * weights[:, :, None], y * weights)
