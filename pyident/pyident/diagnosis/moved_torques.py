"""What torques leave of the equations that are moved in time, and how much of it is there.

Positions that come late by d are torques that come early by d. So all columns stay, and of a least squares
that is solved only the right-hand side changes: r + Δ - B Bᵀ Δ, with an orthonormal basis B of the columns
and Δ the change of the torques. What is left out at reversals and at bends stays where it is as well.
Between samples a torque goes by cubics over four of them (Catmull and Rom 1974): these do not ring behind
the steps of dry friction, and are linear, so that noise stays at its frequencies.
"""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from pyident.diagnosis.base.projection import Base
from pyident.regression.spectrum import Equations


def moved(
    data: Sequence[Equations], levels: Sequence[np.ndarray], base: Base, late: float
) -> list[np.ndarray]:
    """Per log (n, E): what a base leaves once torques go with positions that come late [s].

    levels   per log (n, E), floors of the equations
    """
    changes = []
    for e, level in zip(data, levels, strict=True):
        time, torque = np.arange(len(e.part.target)) * e.band.period, e.part.target
        slope = np.gradient(torque, e.band.period, axis=0)
        change = CubicHermiteSpline(time, torque, slope)(np.clip(time - late, 0.0, time[-1])) - torque
        changes.append(e.band.transform(e.part.all_used(change)).T / level)
    taken = sum(np.tensordot(x, basis, 2) for x, basis in zip(changes, base.basis, strict=True))
    parts = zip(base.residual, changes, base.basis, strict=True)
    return [r + x - basis @ taken for r, x, basis in parts]


def energies_in(residuals: Sequence[np.ndarray], asked: Sequence[np.ndarray]) -> np.ndarray:
    """(n,) of residuals, per log (n, E), where they are asked, per log (n, E)."""
    pairs = zip(residuals, asked, strict=True)
    return np.sum([(np.square(r) * clear).sum(axis=1) for r, clear in pairs], axis=0)


def typical(residuals: Sequence[np.ndarray], asked: Sequence[np.ndarray]) -> float:
    """The mean square of residuals, per log (n, E), where they are asked, per log (n, E).

    It is geometric over coordinates: what another law leaves at one joint is no witness of a delay.
    """
    squares, count = energies_in(residuals, asked), np.sum([clear.sum(axis=1) for clear in asked], axis=0)
    there = (count > 0) & (squares > 0)
    return float(np.exp(np.sum(count[there] * np.log(squares[there] / count[there])) / count[there].sum()))
