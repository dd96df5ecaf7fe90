"""Φ^(l) of an open chain as expressions: the same FEM code, run once on CasADi's symbols.

NumPy arrays of symbols pass through the elements as arrays of numbers do, with one sample.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from pyident.kinematics import chain, link_forces
from pyident.kinematics.structure import Structure


@dataclass(frozen=True)
class Expressions:
    """function (q, dq, ddq) -> every entry of Φ^(l) that is not zero; entries its (row, body, parameter)."""

    function: ca.Function
    entries: tuple[tuple[int, int, int], ...]


def expressions(structure: Structure, gravity: np.ndarray) -> Expressions:
    """Φ^(l) of a chain or tree, rows as its q."""
    n = len(structure.independent)
    inputs = [ca.SX.sym(name, n) for name in ("q", "dq", "ddq")]
    found = chain.nodes(structure, *(_elements(x) for x in inputs))
    entries, values = [], []
    for b, (DF, reaction) in enumerate(link_forces.factors(structure, found, gravity)):
        block = np.einsum("xiN,xpN->ip", DF, reaction)
        for (row, parameter), value in np.ndenumerate(block):
            value = ca.SX(value)
            if not value.is_zero():
                entries.append((row, b, parameter))
                values.append(value)
    return Expressions(ca.Function("Phi", inputs, [ca.cse(ca.vertcat(*values))]), tuple(entries))


def _elements(symbols: ca.SX) -> np.ndarray:
    """(n, 1): a column of CasADi as one sample of NumPy."""
    column = np.empty((symbols.numel(), 1), dtype=object)
    column[:, 0] = ca.vertsplit(symbols)
    return column
