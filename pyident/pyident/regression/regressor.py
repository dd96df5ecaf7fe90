"""Φ, eqs (9)-(11): the generalised forces of eq. (8) per unit of every dynamic parameter."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmodels.joint import parameter_name
from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.conditioning.samples import Conditioned
from pyident.regression.laws import LawColumn, Signals, law_columns
from pyident.regression.links import LinkColumns
from pyident.regression.loads.bodies import body_laws
from pyident.regression.machine.threads import spread

CACHED = 1000  # samples at a time: they stay in a core's cache, and no power of two (cache sets collide)
BLOCK = 2 * CACHED


@dataclass(frozen=True)
class Regressor:
    """matrix N x n x P; rows are `robot.coordinates` and columns `robot.linear_parameters`, by name."""

    matrix: np.ndarray
    rows: tuple[str, ...]
    columns: tuple[str, ...]


def regressor(robot: Robot, motion: Motion) -> Regressor:
    """Φ of the whole motion in memory. Raises ValueError for a motion that is wrong or lacks a signal.

    Parameters that enter a law nonlinearly are taken as the robot has them, and so are stiffness and bodies
    behind the signal `load`.
    """
    rows, columns = robot.coordinates, tuple(robot.linear_parameters)
    matrix = np.zeros((len(motion.q), len(rows), len(columns)))
    builder = _Builder(robot, motion)
    builder.fill(matrix, 0)
    return Regressor(matrix, rows, columns)


def generalised_forces(robot: Robot, motion: Motion, p: np.ndarray) -> np.ndarray:
    """(N, n) [N m, N]: Φ p of the whole motion, without Φ in memory; p (P,).

    Raises ValueError as `regressor` does.
    """
    forces = np.empty((len(motion.q), len(robot.coordinates)))
    for part, Phi in regressor_blocks(robot, motion):
        forces[part] = predicted(Phi, p)
    return forces


def predicted(A: np.ndarray, p: np.ndarray) -> np.ndarray:
    """A p of equations A (B, n, P), (B, n)."""
    return np.matmul(p, A.transpose(1, 2, 0)).T


def residual_of(robot: Robot, part: Conditioned, p: np.ndarray) -> np.ndarray:
    """(N, n) torque less Φ p of a conditioned log, not thinned, 0 where an equation is not used; p (P,)."""
    return part.all_used(part.target - generalised_forces(robot, part.motion, p))


def regressor_blocks(robot: Robot, motion: Motion, block: int = BLOCK) -> Iterator[tuple[slice, np.ndarray]]:
    """Φ piece by piece: (samples, Phi (B, n, P)). Phi is overwritten by the next piece: use or copy it.

    In memory the samples of an entry are neighbours. What is zero in every motion is written once: Phi may
    be scaled in place, but nothing be added to it.

    Raises ValueError as `regressor` does, before the first piece.
    """
    builder = _Builder(robot, motion)
    n, samples = len(robot.coordinates), len(motion.q)
    Phi = np.zeros((n, len(robot.linear_parameters), min(block, samples))).transpose(2, 0, 1)

    def pieces() -> Iterator[tuple[slice, np.ndarray]]:
        for start in range(0, samples, block):
            part = slice(start, min(start + block, samples))
            piece = Phi[: part.stop - start]
            builder.fill(piece, start)
            yield part, piece

    return pieces()


class _Builder:
    """What is known of Φ before the first sample: the structure, where each column stands, the laws."""

    def __init__(self, robot: Robot, motion: Motion):
        names = list(robot.linear_parameters)
        starts = [names.index(f"link{k}.m") for k, _ in enumerate(robot.links, start=1)]
        self.links = LinkColumns(robot, starts)
        self.laws = [(names.index(name), law) for name, law in _laws(robot, motion)]
        last = slice(starts[robot.last_link - 1], starts[robot.last_link - 1] + len(LINK_PARAMETERS))
        self.bodies = [(names.index(name), last, weights) for name, weights in body_laws(robot)]
        self.rates = [np.ascontiguousarray(rate, float) for rate in (motion.q, motion.dq, motion.ddq)]

    def fill(self, Phi: np.ndarray, start: int) -> None:
        """Write Φ of the samples from `start` on into Phi, which is zero or was filled before."""

        def fill_part(part: slice) -> None:
            piece, samples = Phi[part], slice(start + part.start, start + part.stop)
            q, dq, ddq = (rate[samples] for rate in self.rates)
            self.links.fill(piece, (q, dq, ddq))
            for column, law in self.laws:
                piece[:, law.row, column] = law.value(samples)
            for column, link, weights in self.bodies:
                np.matmul(piece[:, :, link], weights, out=piece[:, :, column])

        spread(fill_part, len(Phi), CACHED)


def _laws(robot: Robot, motion: Motion) -> Iterator[tuple[str, LawColumn]]:
    """Parameter and column of every law of every joint."""
    signals = Signals(robot, motion)
    for k, joint in robot.numbered:
        for effect in joint.effects:
            for column in law_columns(robot, signals, k, effect, joint.values[effect.name]):
                yield parameter_name(k, effect.name, column.parameter), column
