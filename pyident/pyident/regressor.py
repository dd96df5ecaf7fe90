"""Φ, eqs (9)-(11): the generalised forces of eq. (8) per unit of every dynamic parameter."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import LINK_PARAMETERS, Robot, parameter_name
from pyident.fem import body, robot_structure, transfer
from pyident.laws import LawColumn, Signals, body_columns, law_columns
from pyident.motion import Motion

CACHED = 1000  # samples at a time: they stay in a core's cache, and no power of two (cache sets collide)


@dataclass(frozen=True)
class Regressor:
    """matrix N x n x P; rows are `robot.coordinates` and columns `robot.linear_parameters`, by name."""

    matrix: np.ndarray
    rows: tuple[str, ...]
    columns: tuple[str, ...]


def regressor(robot: Robot, motion: Motion) -> Regressor:
    """Φ of the whole motion in memory. Raises ValueError for a motion that is wrong or lacks a signal.

    Parameters that enter a law nonlinearly are taken as the robot has them, and so is the stiffness k[1]
    behind the signal `load`.
    """
    rows, columns = robot.coordinates, tuple(robot.linear_parameters)
    matrix = np.empty((len(motion.q), len(rows), len(columns)))
    builder = _Builder(robot, motion)
    builder.fill(matrix, 0)
    return Regressor(matrix, rows, columns)


def regressor_blocks(robot: Robot, motion: Motion, block: int = 4096) -> Iterator[tuple[slice, np.ndarray]]:
    """Φ piece by piece: (samples, Phi (B, n, P)). Phi is overwritten by the next piece: use it or copy it.

    Raises ValueError as `regressor` does, before the first piece.
    """
    builder = _Builder(robot, motion)
    n, samples = len(robot.coordinates), len(motion.q)
    Phi = np.empty((min(block, samples), n, len(robot.linear_parameters)))

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
        self.gravity = np.array(robot.gravity)
        self.structure = robot_structure.of_robot(robot)
        names = list(robot.linear_parameters)
        starts = [names.index(f"link{k}.m") for k, _ in enumerate(robot.links, start=1)]
        self.links = [slice(start, start + len(LINK_PARAMETERS)) for start in starts]
        self.laws = [(names.index(name), law) for name, law in _laws(robot, motion)]
        last = self.links[robot.last_link - 1]
        self.bodies = [(names.index(name), last, weights) for name, weights in _bodies(robot)]
        self.rates = [np.ascontiguousarray(rate, float) for rate in (motion.q, motion.dq, motion.ddq)]

    def fill(self, Phi: np.ndarray, start: int) -> None:
        """Write Φ of the samples from `start` on."""
        for at in range(0, len(Phi), CACHED):
            piece = Phi[at : at + CACHED]
            part = slice(start + at, start + at + len(piece))
            self._fill_links(piece, part)
            self._fill_laws(piece, part)

    def _fill_links(self, Phi: np.ndarray, part: slice) -> None:
        """Φ^(l): virtual power DFᵀ(M x'' − f) of every lumped body, eq. (8)."""
        q, dq, ddq = (np.ascontiguousarray(rate[part].T) for rate in self.rates)
        nodes = transfer.nodes(self.structure, q, dq, ddq)
        for (x, R), columns in zip(self.structure.bodies, self.links, strict=True):
            position, orientation = nodes.positions[x], nodes.orientations[R]
            DF = np.concatenate([position.DF, orientation.DF])
            Y = body.reaction(position, orientation, self.gravity)
            np.matmul(DF.transpose(2, 1, 0), Y.transpose(2, 0, 1), out=Phi[:, :, columns])

    def _fill_laws(self, Phi: np.ndarray, part: slice) -> None:
        Phi[:, :, self.links[-1].stop :] = 0.0
        for column, law in self.laws:
            Phi[:, law.row, column] = law.value(part)
        for column, link, weights in self.bodies:
            np.matmul(Phi[:, :, link], weights, out=Phi[:, :, column])


def _laws(robot: Robot, motion: Motion) -> Iterator[tuple[str, LawColumn]]:
    """Parameter and column of every law of every joint."""
    signals = Signals(robot, motion)
    for k, joint in robot.numbered:
        for effect in joint.effects:
            for column in law_columns(robot, signals, k, effect, joint.values[effect.name]):
                yield parameter_name(k, effect.name, column.parameter), column


def _bodies(robot: Robot) -> Iterator[tuple[str, np.ndarray]]:
    """Parameter of every law that adds to the last link, and its column in terms of that link's."""
    for k, joint in robot.numbered:
        for effect in joint.effects:
            for parameter, weights in body_columns(robot, effect).items():
                yield parameter_name(k, effect.name, parameter), weights
