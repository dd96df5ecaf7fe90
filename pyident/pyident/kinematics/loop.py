"""The geometric transfer function of any structure, closed loops included, after Jonker (1990).

F by Newton iteration on the nodal coordinates; DF and (D²F dq) dq by linear solves with the same matrix:
differentiating D(F(q)) = (0, q) once and twice gives DD DF = (0, I) and DD ẍ = (0, ddq) − (D²D ẋ) ẋ.
"""

import numpy as np

from pyident.kinematics import assembly
from pyident.kinematics.elements.beam import Beam
from pyident.kinematics.elements.nodes import Nodes, Orientation, Position, Shape, at_rest, upright
from pyident.kinematics.elements.triads import compose, turn
from pyident.kinematics.structure import GROUND, ReachError, Structure

STEP = 0.5  # largest change of a coordinate between two converged configurations [rad or m]
NEAR, CLOSE = 1e-2, 1e-7  # errors from which to step on, and to stop: the last update squares the error
ITERATIONS = 20
SPARSE = 16


def nodes(structure: Structure, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> Nodes:
    """Eqs (5)-(7) for N samples: q, dq, ddq (n, N). With ddq = 0 the accelerations are (D²F dq) dq.

    Raises ReachError where the loop cannot close or what is held does not determine the nodes.
    """
    n, samples = q.shape
    shape = configuration(structure, q)
    J = assembly.DD(structure, shape)
    DF = _solve(J, np.broadcast_to(_held(structure, np.eye(n)), (samples, J.shape[1], n)))
    velocity = np.einsum("nij,jn->in", DF, dq)
    v = {node: velocity[3 * i : 3 * i + 3] for i, node in enumerate(structure.moving)}
    v |= {node: np.zeros((3, samples)) for node in GROUND}
    load = _held(structure, ddq) - assembly.D2D(structure, shape, v)
    acceleration = _solve(J, load.T[:, :, None])[:, :, 0].T
    found = Nodes({0: at_rest(np.zeros(3), q)}, {0: upright(q)})
    for i, node in enumerate(structure.moving):
        part = slice(3 * i, 3 * i + 3)
        motion = shape[node], velocity[part], acceleration[part], DF[:, part].transpose(1, 2, 0)
        if node[0] == "x":
            found.positions[node[1]] = Position(*motion)
        else:
            found.orientations[node[1]] = Orientation(*motion)
    return found


def configuration(structure: Structure, q: np.ndarray) -> Shape:
    """F(q): the nodes for q (n, N), followed from the reference configuration in steps.

    Where neighbouring samples lie close, only every `SPARSE`-th is followed; the others start from it.
    """
    few = q[:, ::SPARSE]
    near = few.repeat(SPARSE, axis=1)[:, : q.shape[1]]
    if np.abs(q - near).max(initial=0.0) > STEP:
        return _follow(structure, reference(structure, q.shape[1]), 0 * q, q)
    sparse = _follow(structure, reference(structure, few.shape[1]), 0 * few, few)
    start = {node: value.repeat(SPARSE, axis=-1)[..., : q.shape[1]] for node, value in sparse.items()}
    return _follow(structure, start, near, q)


def _follow(structure: Structure, shape: Shape, start: np.ndarray, end: np.ndarray) -> Shape:
    """From a configuration at q = start to the one at q = end, both (n, N)."""
    steps = max(1, int(np.ceil(np.abs(end - start).max(initial=0.0) / STEP)))
    for k in range(1, steps + 1):
        q = start + (end - start) * k / steps
        for _ in range(ITERATIONS):
            shape, error = newton(structure, shape, q)
            if error.max() < (NEAR if k < steps else CLOSE):
                break
        else:
            at = ", ".join(f"{value:.4g}" for value in q[:, np.argmax(error)])
            raise ReachError(f"the structure does not close at q = ({at}); keep q within its reach")
    return shape


def newton(structure: Structure, shape: Shape, q: np.ndarray) -> tuple[Shape, np.ndarray]:
    """One iteration towards q (n, N): the new configuration, and the largest error (N,) of the old one."""
    gap = _held(structure, q) - assembly.D(structure, shape)
    for i, element in enumerate(structure.elements):
        for mode in element.turns:
            row = structure.rows.get((i, mode))
            if row is not None:
                gap[row] = np.remainder(gap[row] + np.pi, 2 * np.pi) - np.pi
    move = _solve(assembly.DD(structure, shape), gap.T[:, :, None])[:, :, 0].T
    moved = dict(shape)
    for i, node in enumerate(structure.moving):
        part = move[3 * i : 3 * i + 3]
        moved[node] = shape[node] + part if node[0] == "x" else compose(turn(part), shape[node])
    return moved, np.abs(gap).max(axis=0)


def reference(structure: Structure, samples: int) -> Shape:
    """The configuration in which every triad is upright and every beam has its own vector."""
    upright_R = np.tile(np.eye(3)[:, :, None], samples)
    shape: Shape = {node: upright_R for node in structure.moving if node[0] == "R"}
    shape |= {GROUND[0]: np.zeros((3, samples)), GROUND[1]: upright_R}
    for element in structure.elements:
        offset = element.vector[:, None] if isinstance(element, Beam) else 0.0
        for node in element.outer:
            if node not in shape:
                shape[node] = shape[element.inner[0]] + offset
    return shape


def _held(structure: Structure, values: np.ndarray) -> np.ndarray:
    """(0, values): each independent deformation's row of `values` (n, …) among all held ones."""
    target = np.zeros((len(structure.rows), values.shape[1]))
    target[[structure.rows[mode] for mode in structure.independent]] = values
    return target


def _solve(J: np.ndarray, right: np.ndarray) -> np.ndarray:
    try:
        return np.linalg.solve(J, right)
    except np.linalg.LinAlgError:
        raise ReachError(
            "the held deformations do not determine the nodes there (singular); release others or move q"
        ) from None
