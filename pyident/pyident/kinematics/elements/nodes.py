"""The motion of nodes: what the geometric transfer function gives, eqs (5)-(7)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

Node = tuple[Literal["x", "R"], int]  # translational or rotational, and its number; 0 is the ground
Shape = dict[Node, np.ndarray]  # x (3, N) of a translational node, R (3, 3, N) of a rotational one
Velocity = dict[Node, np.ndarray]  # v (3, N) of a translational node, ω (3, N) of a rotational one


@dataclass(frozen=True)
class Position:
    """A translational node over N samples: x, v (3, N) [m, m/s], a (3, N) [m/s²], DF (3, n, N)."""

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    DF: np.ndarray


@dataclass(frozen=True)
class Orientation:
    """A rotational node: R (3, 3, N), ω (3, N) [rad/s], its derivative dw; ω = DF dq with DF (3, n, N)."""

    R: np.ndarray
    w: np.ndarray
    dw: np.ndarray
    DF: np.ndarray


@dataclass(frozen=True)
class Nodes:
    """The nodes known so far: translational and rotational, by their number in the structure."""

    positions: dict[int, Position]
    orientations: dict[int, Orientation]


@dataclass(frozen=True)
class Deformation:
    """What an element's modes do: e, de, dde (modes, N), zero where fixed.

    columns   per mode its place in q, None where the mode is fixed at zero
    """

    e: np.ndarray
    de: np.ndarray
    dde: np.ndarray
    columns: tuple[int | None, ...]


def at_rest(x: np.ndarray, q: np.ndarray) -> Position:
    """A translational node fixed to the ground at x (3,) [m]; samples and kind of number as in q (n, N)."""
    n, samples = q.shape
    still = np.zeros_like(q, shape=(3, samples))
    return Position(np.tile(x[:, None], samples), still, still, np.zeros_like(q, shape=(3, n, samples)))


def upright(q: np.ndarray) -> Orientation:
    """A rotational node fixed to the ground in the reference orientation, for q (n, N)."""
    n, samples = q.shape
    still = np.zeros_like(q, shape=(3, samples))
    return Orientation(
        np.tile(np.eye(3)[:, :, None], samples), still, still, np.zeros_like(q, shape=(3, n, samples))
    )
