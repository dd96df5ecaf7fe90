"""The regression of all logs, eq. (12), as blocks of equations that can be gone through again."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.filters import thin
from pyident.conditioning.samples import Conditioned, Piece
from pyident.regression.loads.bodies import carried_loads
from pyident.regression.loads.tangent import LoadTangent
from pyident.regression.reduced import Reduced, reduce
from pyident.regression.regressor import BLOCK, predicted, regressor_blocks

Block = tuple[np.ndarray, np.ndarray]  # A (B, n, P), y (B, n)


class Part(Protocol):
    """A conditioned log: its samples piece by piece, and the factor by which equations are thinned out."""

    @property
    def thinning(self) -> int: ...
    def pieces(self) -> Iterator[Piece]: ...


@dataclass(frozen=True)
class Problem:
    """A robot and its conditioned logs, in memory or on disk.

    Laws of a rigid joint's load are linear about the robot's own values (`LoadTangent`).
    """

    robot: Robot
    parts: tuple[Part, ...]

    @property
    def rows(self) -> tuple[str, ...]:
        return self.robot.coordinates

    @property
    def columns(self) -> tuple[str, ...]:
        return tuple(self.robot.linear_parameters)

    def blocks(self, weights: Sequence[np.ndarray] | None = None) -> Iterator[Block]:
        """Blocks of every log, one after the other; weights (N, n) per log multiply the equations.

        A block is overwritten by the next one: use it or copy it.
        """
        for i, part in enumerate(self.parts):
            yield from self._blocks(part, None if weights is None else weights[i])

    def reduced(self, weights: Sequence[np.ndarray] | None = None) -> Reduced:
        """The equations folded into triangles; weights as of `blocks`."""
        return reduce(self.blocks(weights), self.rows, self.columns, LoadTangent(self.robot).shift)

    def residuals(self, p: np.ndarray) -> list[np.ndarray]:
        """y − A p per log, (N, n)."""
        return [
            np.concatenate([y - predicted(A, p) for A, y in self._blocks(part, None)]) for part in self.parts
        ]

    def _blocks(self, part: Part, weights: np.ndarray | None) -> Iterator[Block]:
        at = 0
        for piece in part.pieces():
            blocks = _whole(self.robot, piece) if part.thinning == 1 else _thinned(self.robot, piece)
            for A, y in blocks:
                if weights is not None:
                    weigh(A, y, weights[at : at + len(y)])
                    at += len(y)
                yield A, y


def _whole(robot: Robot, piece: Piece) -> Iterator[Block]:
    part = piece.conditioned.cut(piece.own)
    means = free_means(part, ((Phi, y, part.use[at]) for at, Phi, y in _linear(robot, part, BLOCK)))
    for at, Phi, y in _linear(robot, part, BLOCK):
        centre(Phi, y, means)
        weigh(Phi, y, part.use[at])
        yield Phi, y


def _thinned(robot: Robot, piece: Piece) -> Iterator[Block]:
    part = piece.conditioned
    factor, samples = part.thinning, len(part.target)
    kept = slice(piece.own.start // factor, -(-piece.own.stop // factor))
    ((_, Phi, target),) = _linear(robot, part, samples)
    y = thin(target, factor)[kept]
    A = np.zeros((len(y), len(robot.coordinates), len(robot.linear_parameters)))
    for row in range(A.shape[1]):
        columns = np.flatnonzero(Phi[:, row].any(axis=0))
        A[:, row, columns] = thin(Phi[:, row, columns], factor)[kept]
    use = part.use[::factor][kept]
    centre(A, y, free_means(part, [(A, y, use)]))
    weigh(A, y, use)
    yield A, y


def _linear(robot: Robot, part: Conditioned, block: int) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
    """Samples, and the equations Φ (B, n, P), y (B, n) there; a block is overwritten by the next one."""
    tangent = LoadTangent(robot)
    loads = carried_loads(robot, part.motion) if tangent.acting else None
    for at, Phi in regressor_blocks(robot, part.motion, block):
        y = part.target[at].copy()
        if loads is not None:
            tangent.take(Phi, y, loads[at])
        yield at, Phi, y


def free_means(
    part: Conditioned, blocks: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]]
) -> dict[int, tuple[np.ndarray, float]]:
    """Free equation -> means (P,) of its A and of its y over the samples in use; blocks: A, y, use."""
    if not part.free:
        return {}
    size, free = len(part.target[0]), list(part.free)
    of_A: dict[int, np.ndarray] = {}
    of_y, count = np.zeros(size), np.zeros(size)
    for A, y, use in blocks:
        for row in free:
            of_A[row] = of_A.get(row, 0.0) + use[:, row] @ A[:, row]
        of_y += (use * y).sum(axis=0)
        count += use.sum(axis=0)
    count = np.maximum(count, 1.0)
    return {row: (of_A[row] / count[row], float(of_y[row] / count[row])) for row in free}


def centre(A: np.ndarray, y: np.ndarray, means: Mapping[int, tuple[np.ndarray, float]]) -> None:
    """Take means of free equations, as of `free_means`, away from A (N, n, P) and y (N, n), in place."""
    for row, (of_A, of_y) in means.items():
        A[:, row] -= of_A
        y[:, row] -= of_y


def weigh(A: np.ndarray, y: np.ndarray, weights: np.ndarray) -> None:
    """Multiply equations by weights (B, n), in place."""
    y *= weights
    for row in np.flatnonzero((weights != 1).any(axis=0)):
        A[:, row] *= weights[:, row, None]
