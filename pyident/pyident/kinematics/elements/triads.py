"""Algebra of vectors (3, ..., N) and triads (3, 3, N); components come first, samples last."""

import numpy as np


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product (...) over the first axis of a, b (3, ...)."""
    return np.einsum("i...,i...->...", a, b)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vector product (3, ...) over the first axis; other axes broadcast, so a Jacobian may meet a vector."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def rotate(R: np.ndarray, v: np.ndarray) -> np.ndarray:
    """R v (3, ...): components along the axes of R (3, 3, ...) to components in base axes."""
    return np.einsum("ij...,j...->i...", R, v)


def unrotate(R: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Rᵀ v (3, ...): components in base axes to components along the axes of R (3, 3, ...)."""
    return np.einsum("ji...,j...->i...", R, v)


def compose(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """A B for (3, 3, N) and (3, m, N) in either place; a constant (3, 3) serves every sample."""
    return np.einsum("ij...,jk...->ik...", A, B)


def spin(w: np.ndarray, n: np.ndarray) -> np.ndarray:
    """ω × each axis of a triad: the rate of n (3, 3, N) that turns with ω (3, N)."""
    return cross(w[:, None], n)


def turning(w: np.ndarray, n: np.ndarray) -> np.ndarray:
    """A triad that turns at constant ω, with its first and second derivative: (3 orders, 3, 3, N)."""
    dn = spin(w, n)
    return np.stack([n, dn, spin(w, dn)])


def second_rate(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Second derivative of a·b; a and b come with their derivatives, (3 orders, 3, N)."""
    return dot(a[2], b[0]) + 2 * dot(a[1], b[1]) + dot(a[0], b[2])


def axes(n: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x', y', z' (3, N) of a triad (3, 3, N), or of a triad with its derivatives."""
    return n[..., 0, :], n[..., 1, :], n[..., 2, :]


def about_x(e: np.ndarray) -> np.ndarray:
    """Rotation about x by e [rad], (N,) -> (3, 3, N)."""
    R = np.zeros_like(e, shape=(3, 3, *e.shape))
    R[0, 0] = 1.0
    R[1, 1] = R[2, 2] = np.cos(e)
    R[2, 1] = np.sin(e)
    R[1, 2] = -R[2, 1]
    return R


def turn(theta: np.ndarray) -> np.ndarray:
    """Rotation by a rotation vector theta [rad], (3, N) -> (3, 3, N)."""
    angle = np.sqrt(dot(theta, theta))
    sine, versine = np.sinc(angle / np.pi), np.sinc(angle / (2 * np.pi)) ** 2 / 2
    unit = np.eye(3)[:, :, None] + 0 * angle
    return unit + sine * spin(theta, unit) + versine * spin(theta, spin(theta, unit))
