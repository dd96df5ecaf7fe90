"""Assembly: the deformations of all elements as functions of the nodes that they share.

Rows are the held modes (fixed or independent), element by element; columns are the velocities of the
nodes that are not the ground, three each: translational ẋ or rotational ω.
"""

import numpy as np

from pyident.kinematics.elements.nodes import Shape, Velocity
from pyident.kinematics.structure import Structure


def D(structure: Structure, shape: Shape) -> np.ndarray:
    """Held deformations (m, N) in a configuration."""
    return np.concatenate([element.D(shape)[list(held)] for element, held in structure.held])


def DD(structure: Structure, shape: Shape) -> np.ndarray:
    """Rates of the held deformations per unit of the nodal velocities, (N, m, m)."""
    samples = shape["x", 0].shape[-1]
    size = 3 * len(structure.moving)
    J = np.zeros((size, size, samples))
    column = {node: slice(3 * i, 3 * i + 3) for i, node in enumerate(structure.moving)}
    row = 0
    for element, held in structure.held:
        rates = element.DD(shape)[list(held)]
        rows = slice(row, row + len(held))
        for i, node in enumerate(element.inner + element.outer):
            if node in column:
                J[rows, column[node]] += rates[:, 3 * i : 3 * i + 3]
        row += len(held)
    return J.transpose(2, 0, 1)


def D2D(structure: Structure, shape: Shape, velocity: Velocity) -> np.ndarray:
    """Second derivatives of the held deformations while the nodal velocities are constant, (m, N)."""
    return np.concatenate([element.D2D(shape, velocity)[list(held)] for element, held in structure.held])
