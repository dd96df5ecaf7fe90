"""How much each equation counts at each frequency: by one over what it leaves there, where that grows.

Differences raise the noise of high frequencies; instruments without what is lost in it have less noise in
their sums, as the refined instruments of Young and Jakeman (1979), which go through the noise's model. A
residual that falls with frequency is a missing law more often than noise: there nothing is taken off, so that
the model found stays the one that predicts the torque.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyident.estimation.instrumental_variables import Rows
from pyident.refinement.instruments.residual_spectrum import smoothed_power, transform_length
from pyident.refinement.instruments.simulated_rows import Data


def counted_alike(rows: Sequence[Rows], p: np.ndarray) -> np.ndarray:
    """The weights (n,) of the coordinates' equations by all that they leave, every frequency alike.

    Where no loop is known, what a model lacks is more of that than noise.
    """
    squares = sum(np.sum((r.residual(p) * r.share) ** 2, axis=0) for r in rows)
    return _weights(np.sqrt(squares / sum(len(r.y) for r in rows)))


def counted_by_noise(
    data: Sequence[Data], rows: Sequence[Rows], p: np.ndarray
) -> tuple[list[Rows], np.ndarray]:
    """Rows whose instruments went through the filters, and the weights (n,) of the coordinates' equations.

    p   (P,) parameters whose residual is the measure of noise
    """
    powers = [_power(d, r, p) for d, r in zip(data, rows, strict=True)]
    level = np.sqrt(sum(power[0] for power in powers) / sum(len(r.y) for r in rows))
    return [_filtered(r, power) for r, power in zip(rows, powers, strict=True)], _weights(level)


def _weights(level: np.ndarray) -> np.ndarray:
    return 1 / np.maximum(level, 1e-6 * level.max())


def _power(data: Data, rows: Rows, p: np.ndarray) -> np.ndarray:
    """(bins, n) of what the log leaves and of what samples do, never falling towards higher frequencies."""
    scatter = rows.residual(p) * rows.share
    shift = (data.y - rows.y) * rows.share
    return np.maximum.accumulate(smoothed_power(scatter) + smoothed_power(shift), axis=0)


def _filtered(rows: Rows, power: np.ndarray) -> Rows:
    """The instruments that count, each frequency by the least power over the power."""
    N, Z = len(rows.y), np.zeros_like(rows.Z)
    length = transform_length(N)
    for c, columns in enumerate(rows.columns):
        passes = power[0, c] / np.maximum(power[:, c], 1e-300)
        lines = np.fft.rfft(rows.Z[:, c, columns].T * rows.share[:, c], length)
        Z[:, c, columns] = np.fft.irfft(lines * passes, length)[:, :N].T
    return replace(rows, Z=Z)
