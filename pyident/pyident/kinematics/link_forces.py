"""Φ^(l), eq. (8): the generalised forces of the lumped bodies per unit of their parameters."""

from collections.abc import Iterator

import numpy as np

from pyident.kinematics.elements import body
from pyident.kinematics.elements.nodes import Nodes
from pyident.kinematics.structure import Structure

Factors = tuple[np.ndarray, np.ndarray]  # DF (6, n, N) of a body's nodes and its reaction (6, 10, N)


def factors(structure: Structure, found: Nodes, gravity: np.ndarray) -> Iterator[Factors]:
    """Per body DF and M x'' − f, whose virtual power DFᵀ (M x'' − f) is the body's block (n, 10) of Φ."""
    for x, R in structure.bodies:
        position, orientation = found.positions[x], found.orientations[R]
        yield np.concatenate([position.DF, orientation.DF]), body.reaction(position, orientation, gravity)
