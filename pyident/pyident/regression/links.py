"""Φ^(l) of many samples: the FEM of an open chain compiled, any other structure and machine by NumPy.

Both paths are one derivation: the C comes from the FEM code itself, run once on symbols. Passive joints that
follow the motors linearly make an open chain as well, with more coordinates (see `kinematics.tree`).
"""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.kinematics import link_forces, robot_structure, source, symbolic, transfer
from pyident.kinematics.elements import hinge
from pyident.kinematics.elements.hinge import Hinge
from pyident.kinematics.structure import Structure
from pyident.kinematics.tree import Tree, tree_of
from pyident.regression.machine.compiled import library

_known: dict[str, "Compiled | None"] = {}  # by content of structure and gravity
_agreed: dict[str, bool] = {}  # by content of a structure: whether its passive joints follow
Rates = tuple[np.ndarray, np.ndarray, np.ndarray]  # q, dq, ddq, each (N, n), contiguous rows of floats


@dataclass(frozen=True)
class Compiled:
    """fill of lanes.h, and of each entry that it writes the row, the body and the body's parameter (E,)."""

    fill: Callable[..., None]
    rows: np.ndarray
    bodies: np.ndarray
    parameters: np.ndarray


class LinkColumns:
    """The columns of a robot's links in Φ; starts: of each link the column of its first parameter."""

    def __init__(self, robot: Robot, starts: list[int]):
        self.starts = np.array(starts)
        self.gravity = np.array(robot.gravity)
        self.hung = _Hung(tree_of(robot)) if robot.passive else None
        self.structure = self.hung.tree.pinned if self.hung else robot_structure.of_robot(robot)
        chain = self.hung is None and self.structure.is_chain
        self.compiled = compiled(self.structure, self.gravity) if chain else None

    def fill(self, Phi: np.ndarray, rates: Rates) -> None:
        """Write into Phi (N, n, P), of any strides. Entries that are zero in every motion stay as they are.

        Raises ValueError for a hinge bent too far, ReachError for a loop that does not close.
        """
        if self.hung is not None and self.hung.follows:
            self.hung.fill(Phi, rates, self.starts)
            return
        if self.compiled is None:
            self._fill_by_numpy(Phi, rates)
            return
        check_bends(self.structure, rates[0])
        per_sample, per_row, per_column = (stride // Phi.itemsize for stride in Phi.strides)
        columns = self.starts[self.compiled.bodies] + self.compiled.parameters
        place = self.compiled.rows * per_row + columns * per_column
        pointers = (array.ctypes.data for array in (*rates, Phi, place))
        self.compiled.fill(len(Phi), *pointers, per_sample)

    def _fill_by_numpy(self, Phi: np.ndarray, rates: Rates) -> None:
        q, dq, ddq = (np.ascontiguousarray(rate.T) for rate in rates)
        found = transfer.nodes(self.structure, q, dq, ddq)
        for start, (DF, reaction) in zip(
            self.starts, link_forces.factors(self.structure, found, self.gravity), strict=True
        ):
            block = Phi[:, :, start : start + len(LINK_PARAMETERS)]
            np.matmul(DF.transpose(2, 1, 0), reaction.transpose(2, 0, 1), out=block)


class _Hung:
    """The columns of a robot whose passive joints follow, from those of its tree."""

    def __init__(self, tree: Tree):
        self.tree = tree
        width = len(LINK_PARAMETERS)
        self.columns = LinkColumns(tree.robot, [width * k for k in range(len(tree.robot.links))])

    @cached_property
    def follows(self) -> bool:
        """Whether its tree agrees with its pins, tried once for all robots of a structure."""
        content = f"{self.tree.pinned.content} {self.tree.turns.tolist()}"
        if content not in _agreed:
            _agreed[content] = self.tree.agrees()
        return _agreed[content]

    def fill(self, Phi: np.ndarray, rates: Rates, starts: np.ndarray) -> None:
        """As of LinkColumns; starts (links,): of each link's parameters in Phi."""
        width, turns = len(LINK_PARAMETERS), self.tree.turns
        hung = np.zeros((len(rates[0]), len(turns), width * len(starts)))
        q, dq, ddq = (np.ascontiguousarray(rate @ turns.T) for rate in rates)
        self.columns.fill(hung, (q, dq, ddq))
        for k, start in enumerate(starts):
            Phi[:, :, start : start + width] = turns.T @ hung[:, :, width * k : width * (k + 1)]


def compiled(structure: Structure, gravity: np.ndarray) -> Compiled | None:
    """The C of a chain's Φ^(l), compiled; None where there is no compiler."""
    content = f"{structure.content} {gravity.tolist()}"
    if content not in _known:
        _known[content] = _compile(structure, gravity)
    return _known[content]


def check_bends(structure: Structure, q: np.ndarray) -> None:
    """Raises ValueError where q (N, n) bends a hinge by a right angle."""
    for element, columns in zip(structure.elements, structure.columns, strict=True):
        place = [column for column in columns if column is not None]
        if isinstance(element, Hinge) and len(place) == element.modes:
            hinge.check_bend(q[:, place].T)


def _compile(structure: Structure, gravity: np.ndarray) -> Compiled | None:
    phi = symbolic.expressions(structure, gravity)
    loaded = library(source.source(phi.function))
    if loaded is None:
        return None
    pointer, size = ctypes.c_void_p, ctypes.c_ssize_t
    loaded.fill.argtypes = [size, pointer, pointer, pointer, pointer, pointer, size]
    loaded.fill.restype = None
    rows, bodies, parameters = (np.array(x, dtype=np.intp) for x in zip(*phi.entries, strict=True))
    return Compiled(loaded.fill, rows, bodies, parameters)
