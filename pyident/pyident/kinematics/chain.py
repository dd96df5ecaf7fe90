"""The geometric transfer function of an open chain, by direct recursion from the ground outwards."""

import numpy as np

from pyident.kinematics.elements.nodes import Deformation, Nodes, at_rest, upright
from pyident.kinematics.structure import Structure


def nodes(structure: Structure, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> Nodes:
    """Eqs (5)-(7) for N samples: q, dq, ddq (n, N). With ddq = 0 the accelerations are (D²F dq) dq."""
    found = Nodes({0: at_rest(np.zeros(3), q)}, {0: upright(q)})
    fixed = np.zeros(q.shape[1])
    for element, columns in zip(structure.elements, structure.columns, strict=True):
        e, de, dde = (np.stack([fixed if j is None else rate[j] for j in columns]) for rate in (q, dq, ddq))
        element.carry(found, Deformation(e, de, dde, columns))
    return found
