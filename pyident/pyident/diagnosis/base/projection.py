"""What further columns would explain of a residual, once the base model has taken what it can.

With A p = y the base equations (whitened: their floor is one), r their residual and X further columns, the
part of X that the base cannot imitate is X⊥ = X − A A⁺X. The columns then explain

    gain = rᵀX⊥ (X⊥ᵀX⊥)⁻¹ X⊥ᵀr      of the energy rᵀr,   at the coefficients (X⊥ᵀX⊥)⁻¹ X⊥ᵀr,

where only coefficients within their physical bounds count (Frisch and Waugh 1933; Lovell 1963).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import lsq_linear

from pyident.regression.machine.svd import svd
from pyident.regression.spectrum import Equations
from pyident.regression.triangle import Triangle

IMITATED = 1e-6  # share of a column's energy that the base must leave for it to count at all
_STEPS = 10  # per coefficient, in which those at their bounds are found
CANCELLED = 1e-13  # of the longest column: what is left of forces that cancel, as of a moment about gravity
_ROUNDING = 1e-9  # of the largest singular value of the base: below is arithmetic

Columns = Sequence[Mapping[int, np.ndarray]]  # per log: row -> (E, K) whitened columns
Limits = tuple[np.ndarray, np.ndarray]  # lower and upper (K,) of their coefficients


@dataclass(frozen=True)
class Base:
    """The base equations of all logs, solved.

    p           (P,) smallest solution
    directions  (P, R): parameters per unit of the basis' first R vectors
    basis       per log (n, E, R or more): an orthonormal basis of what the base can imitate
    residual    per log (n, E)
    """

    p: np.ndarray
    directions: np.ndarray
    basis: list[np.ndarray]
    residual: list[np.ndarray]

    @property
    def energy(self) -> float:
        return float(sum(np.square(r).sum() for r in self.residual))


@dataclass(frozen=True)
class Gain:
    """What K columns explain.

    coefficients, std   (K,); std inf: the base, or the other columns, imitate this one
    alone               (K,) standard deviation of each column's coefficient without the others
    left                largest share of a combination of them that the base cannot imitate
    """

    energy: float
    coefficients: np.ndarray
    std: np.ndarray
    alone: np.ndarray
    left: float


def solve_base(whitened: Sequence[Equations]) -> Base:
    """Least squares over all logs."""
    p, directions = solution_of(triangles(whitened))
    return Base(p, directions, [e.A @ directions for e in whitened], [e.y - e.A @ p for e in whitened])


def residuals_of(whitened: Sequence[Equations]) -> list[np.ndarray]:
    """Per log (n, E), what the base's least squares leaves."""
    p, _ = solution_of(triangles(whitened))
    return [e.y - e.A @ p for e in whitened]


def triangles(whitened: Sequence[Equations]) -> list[np.ndarray]:
    """Per equation the triangle (P + 1, P + 1) of [A, y] over all logs."""
    found = []
    for row in range(len(whitened[0].y)):
        own = Triangle(whitened[0].A.shape[2])  # of the few columns that act there
        for e in whitened:
            own.fold(e.A[row], e.y[row])
        found.append(own.full)
    return found


def solution_of(rows: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """`p` (P,) and `directions` (P, R) of a base, from its equations' triangles."""
    scale = np.sqrt(sum(np.square(R[:, :-1]).sum(axis=0) for R in rows))
    acting = scale > CANCELLED * scale.max()
    scale[~acting] = 1.0
    triangle = Triangle(len(scale))
    for R in rows:
        triangle.fold(R[:, :-1] * acting / scale, R[:, -1])
    R = triangle.full
    U, s, Vt = svd(R[:, :-1])
    kept = s > _ROUNDING * s[0]
    directions = Vt[kept].T / s[kept] / scale[:, None]
    return directions @ (U.T @ R[:, -1])[kept], directions


def gain(
    base: Base, columns: Columns, lower: np.ndarray | None = None, upper: np.ndarray | None = None
) -> Gain:
    """Of K columns, with bounds (K,) on their coefficients; none: any coefficient."""
    K = _width(columns)
    lower = np.full(K, -np.inf) if lower is None else lower
    upper = np.full(K, np.inf) if upper is None else upper
    return gains(base, [columns], [(lower, upper)])[0]


def gains(base: Base, listed: Sequence[Columns], limits: Sequence[Limits]) -> list[Gain]:
    """Of each set of columns by itself, with lower and upper bounds on its coefficients."""
    ends = np.cumsum([0, *(_width(columns) for columns in listed)])
    parts = [slice(a, b) for a, b in pairwise(ends.tolist())]
    b, g = np.zeros((base.basis[0].shape[2], ends[-1])), np.zeros(ends[-1])
    G = [np.zeros((part.stop - part.start,) * 2) for part in parts]
    for log, (basis, residual) in enumerate(zip(base.basis, base.residual, strict=True)):
        for c in sorted({c for columns in listed for c in columns[log]}):
            acting = [i for i, columns in enumerate(listed) if c in columns[log]]
            own = [listed[i][log][c] for i in acting]
            place = np.concatenate([np.arange(ends[-1])[parts[i]] for i in acting])
            X = np.hstack(own)
            b[:, place] += basis[c].T @ X
            g[place] += X.T @ residual[c]
            for i, x in zip(acting, own, strict=True):
                G[i] += x.T @ x
    return [
        System.of(full, full - b[:, part].T @ b[:, part]).solved(g[part], *bounds)
        for full, part, bounds in zip(G, parts, limits, strict=True)
    ]


def _width(columns: Columns) -> int:
    return next(X.shape[1] for rows in columns for X in rows.values())


@dataclass(frozen=True)
class Others:
    """Other residuals of the same motion, per log (n, E) each, and what the basis has of each, (R,)."""

    residuals: Sequence[Sequence[np.ndarray]]
    along: Sequence[np.ndarray]


def others_of(base: Base, residuals: Sequence[Sequence[np.ndarray]]) -> Others:
    """What a base and other residuals, each (n, bins) per log, have in common, once for all columns."""
    along = [
        np.sum([np.tensordot(r, basis, 2) for basis, r in zip(base.basis, left, strict=True)], axis=0)
        for left in residuals
    ]
    return Others(residuals, along)


def gains_over(
    base: Base, columns: Columns, others: Others, lower: np.ndarray, upper: np.ndarray
) -> list[float]:
    """Energies that K columns, bounded by lower and upper (K,), explain of other residuals of the motion."""
    K = len(lower)
    G, b = np.zeros((K, K)), np.zeros((base.basis[0].shape[2], K))
    for rows, basis in zip(columns, base.basis, strict=True):
        for c, X in rows.items():
            G += X.T @ X
            b += basis[c].T @ X
    system, out = System.of(G, G - b.T @ b), []
    for left, along in zip(others.residuals, others.along, strict=True):
        g = (
            sum(X.T @ r[c] for rows, r in zip(columns, left, strict=True) for c, X in rows.items())
            - b.T @ along
        )
        out.append(system.solved(np.asarray(g), lower, upper).energy)
    return out


def taken_over(base: Base, columns: Columns) -> np.ndarray:
    """(P, K) parameters with which the base imitates K columns as well as it can."""
    R = base.directions.shape[1]
    inside = sum(
        basis[c][:, :R].T @ X
        for rows, basis in zip(columns, base.basis, strict=True)
        for c, X in rows.items()
    )
    return base.directions @ np.asarray(inside)


def joined(several: Sequence[Columns]) -> Columns:
    """The columns of several candidates side by side."""
    out = []
    for logs in zip(*several, strict=True):
        shapes = [next(iter(rows.values())).shape for rows in logs]
        present = {c for rows in logs for c in rows}
        out.append(
            {
                c: np.hstack([rows.get(c, np.zeros(s)) for rows, s in zip(logs, shapes, strict=True)])
                for c in present
            }
        )
    return out


def wider(logs: Sequence[Equations], columns: Columns) -> list[Equations]:
    """The equations with K more unknowns, after the others."""
    out = []
    for log, rows in zip(logs, columns, strict=True):
        K = next(iter(rows.values())).shape[1]
        dense = np.zeros((*log.y.shape, K))
        for row, X in rows.items():
            dense[row] = X
        out.append(replace(log, A=np.concatenate([log.A, dense], axis=2)))
    return out


def falls(base: Base, columns: Columns) -> list[np.ndarray]:
    """Per log (n, E) energy that K columns with free coefficients take of each equation's residual."""
    new = _directions(base, columns)
    part = sum(np.einsum("cek,ce->k", d, r) for d, r in zip(new, base.residual, strict=True))
    pairs = zip(new, base.residual, strict=True)
    return [np.square(r) - np.square(r - d @ part) for d, r in pairs]


def fall_per_row(base: Base, columns: Columns) -> np.ndarray:
    """(n,) the same of each row."""
    return np.sum([log.sum(axis=1) for log in falls(base, columns)], axis=0)


def extended(base: Base, columns: Columns) -> Base:
    """The base with K columns joined to it (`p` stays that of the base's own columns)."""
    new = _directions(base, columns)
    part = sum(np.einsum("cek,ce->k", d, r) for d, r in zip(new, base.residual, strict=True))
    return Base(
        base.p,
        base.directions,
        [np.concatenate([old, d], axis=2) for old, d in zip(base.basis, new, strict=True)],
        [r - d @ part for d, r in zip(new, base.residual, strict=True)],
    )


def _directions(base: Base, columns: Columns) -> list[np.ndarray]:
    """Per log (n, E, K or fewer): an orthonormal basis of what the base cannot imitate of K columns."""
    R = base.basis[0].shape[2]
    K = next(X.shape[1] for rows in columns for X in rows.values())
    b, G = np.zeros((R, K)), np.zeros((K, K))
    for rows, basis in zip(columns, base.basis, strict=True):
        for c, X in rows.items():
            b += basis[c].T @ X
            G += X.T @ X
    new = []
    for rows, basis in zip(columns, base.basis, strict=True):
        dense = -(basis @ b)
        for c, X in rows.items():
            dense[c] += X
        new.append(dense)
    size = np.sqrt(np.maximum(np.diag(G), 1e-300))
    w, V = np.linalg.eigh(sum(np.einsum("cek,cel->kl", d, d) for d in new) / np.outer(size, size))
    kept = w > IMITATED
    directions = V[:, kept] / np.sqrt(w[kept]) / size[:, None]
    return [d @ directions for d in new]


@dataclass(frozen=True)
class System:
    """G of K columns beyond the base, taken apart once for all residuals; size (K,): of the whole columns."""

    size: np.ndarray
    alone: np.ndarray
    w: np.ndarray
    V: np.ndarray
    kept: np.ndarray

    @staticmethod
    def of(full: np.ndarray, G: np.ndarray) -> "System":
        size = np.sqrt(np.maximum(np.diag(full), 1e-300))
        own = np.diag(G) / size**2
        alone = np.where(own > IMITATED, 1 / np.sqrt(np.maximum(own, IMITATED)) / size, np.inf)
        w, V = np.linalg.eigh(G / np.outer(size, size))
        return System(size, alone, w, V, w > IMITATED)

    def solved(self, g: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Gain:
        """g (K,): the columns times a residual."""
        size, left = self.size, float(self.w[-1])
        if not self.kept.any():
            return Gain(0.0, np.zeros(len(g)), np.full(len(g), np.inf), self.alone, left)
        V, root = self.V[:, self.kept], np.sqrt(self.w[self.kept])
        half = V * root  # G = half halfᵀ, in scaled columns
        target = V.T @ (g / size) / root
        x = V @ (target / root) / size
        if len(x) == 1:
            x = np.clip(x, lower, upper)
        elif (x < lower).any() or (x > upper).any():
            lo, hi = lower * size, upper * size
            ends, most = (lo, np.maximum(hi, lo + 1e-300)), _STEPS * len(x)
            x = np.asarray(lsq_linear(half.T, target, ends, method="bvls", max_iter=most).x) / size
        z = half.T @ (x * size)
        free = np.square(self.V[:, ~self.kept]).sum(axis=1) > IMITATED
        std = np.where(free, np.inf, np.sqrt(np.square(V / root).sum(axis=1)) / size)
        return Gain(float(2 * z @ target - z @ z), x, std, self.alone, left)
