"""What a base leaves beyond what any replica leaves: in all equations of a row, or in one band of them.

Below the frequencies in which a log shows its torques' noise, this may rise besides (see `rise`). A log whose
motion repeats shows it to the bottom, so that a band is judged by the logs that know it best.
"""

from dataclasses import dataclass

import numpy as np

from pyident.diagnosis.base.projection import Base
from pyident.diagnosis.base.residual_over_floor import EDGES, Examination
from pyident.simulation.noise.rise import rise


@dataclass(frozen=True)
class InBands:
    """Of each equation and band, all (n, bands).

    ratio   energy that a base leaves over that of replicas; 0 where a band holds no equation
    most    the most that a replica leaves there, over the average
    rise    energy of noise that may be there, over that of replicas
    """

    ratio: np.ndarray
    most: np.ndarray
    rise: np.ndarray

    def above(self, least: float | np.ndarray) -> np.ndarray:
        """(n, bands) where a base leaves more than so many floors, and more than any replica."""
        return self.ratio > np.maximum(least, self.most)


def over_floor(examination: Examination, base: Base) -> np.ndarray:
    """(n,) energy that a base leaves on each equation over that of replicas."""
    left = sum(np.square(r).sum(axis=1) for r in base.residual)
    return np.asarray(left) / np.maximum(examination.floor_energies, 1e-300)


def in_bands(examination: Examination, base: Base) -> InBands:
    """What a base leaves in each band, in the logs that show best what noise is there."""
    ex, rise = examination, _rises(examination)
    if (rise == rise[0]).all():
        left = ex.by_band(base.residual).sum(axis=0)
        mean, each = ex.replica_energy.mean(axis=0), ex.replica_energy
        ratio = left / np.maximum(mean * ex.count, 1e-300) * (ex.count > 0)
        return InBands(ratio, each.max(axis=0) / np.maximum(mean, 1e-300), rise[0])
    held = np.array([log.any(axis=0) for log in ex.bands])[:, None]  # (logs, 1, bands)
    rise = np.where(held, rise, np.inf)
    least = rise.min(axis=0)
    known = (rise == least) & held
    each = (ex.replicas_by_band * known).sum(axis=1)
    mean = np.maximum(each.mean(axis=0), 1e-300)
    ratio = (ex.by_band(base.residual) * known).sum(axis=0) / mean * known.any(axis=0)
    return InBands(ratio, each.max(axis=0) / mean, np.where(np.isfinite(least), least, 1.0))


def standing_out(examination: Examination, base: Base) -> np.ndarray:
    """(n,) by equation: by far more than replicas on average, and more than any; in all or in a band."""
    ex, rules, may_rise = examination, examination.setting.rules.search, _rises(examination).max(axis=0)
    rises = np.where(may_rise > 1, 1 + rules.band_stands_out * may_rise, 1 + rules.stands_out)
    shares = ex.replica_energy.mean(axis=0) * ex.count
    least = (rises * shares).sum(axis=1) / np.maximum(shares.sum(axis=1), 1e-300)
    in_all = over_floor(ex, base) > np.maximum(least, ex.most_over_floor)
    return in_all | bands_standing_out(ex, base).any(axis=1)


def bands_standing_out(examination: Examination, base: Base) -> np.ndarray:
    """(n, bands) by equation and band: the same there. Noise of all others must not dilute it."""
    found = in_bands(examination, base)
    return found.above(1 + examination.setting.rules.search.band_stands_out * found.rise)


def bands_in_doubt(examination: Examination, base: Base) -> np.ndarray:
    """(n, bands) where a residual would stand out but for what slow noise may do."""
    found, more = in_bands(examination, base), examination.setting.rules.search.band_stands_out
    return found.above(1 + more) & ~found.above(1 + more * found.rise)


def unsettled(examination: Examination, base: Base) -> bool:
    """Whether anything stands out, or would but for what slow noise may do."""
    out = standing_out(examination, base).any() or bands_in_doubt(examination, base).any()
    return bool(out)


def _rises(ex: Examination) -> np.ndarray:
    """(logs, n, bands) how far a noise that rises where it was not measured exceeds the floor."""
    top = max(EDGES[-1], float(ex.floor.frequencies[-1]))
    edges = np.array([*EDGES, top])
    middle = (edges[:-1] + edges[1:]) / 2
    return rise(middle, ex.setting.continued[..., None])
