"""What a base leaves beyond what any replica leaves: in all equations of a row, or in one band of them."""

import numpy as np

from pyident.diagnosis.base.projection import Base
from pyident.diagnosis.base.residual_over_floor import Examination


def over_floor(examination: Examination, base: Base) -> np.ndarray:
    """(n,) energy that a base leaves on each equation over that of replicas."""
    left = sum(np.square(r).sum(axis=1) for r in base.residual)
    return np.asarray(left) / np.maximum(examination.floor_energies, 1e-300)


def standing_out(examination: Examination, base: Base) -> np.ndarray:
    """(n,) by equation: by far more than replicas on average, and more than any; in all or in a band."""
    ex, rules = examination, examination.setting.rules.search
    rises = np.where(ex.may_rise > 1, 1 + rules.band_stands_out * ex.may_rise, 1 + rules.stands_out)
    shares = ex.replica_energy.mean(axis=0) * ex.count
    least = (rises * shares).sum(axis=1) / np.maximum(shares.sum(axis=1), 1e-300)
    in_all = over_floor(ex, base) > np.maximum(least, ex.most_over_floor)
    return in_all | bands_standing_out(ex, base).any(axis=1)


def bands_standing_out(examination: Examination, base: Base) -> np.ndarray:
    """(n, bands) by equation and band: the same there. Noise of all others must not dilute it."""
    ex, rules = examination, examination.setting.rules.search
    least = np.maximum(1 + rules.band_stands_out * ex.may_rise, ex.most_in_bands)
    return ex.over_floor_in_bands(base) > least


def bands_in_doubt(examination: Examination, base: Base) -> np.ndarray:
    """(n, bands) where a residual would stand out but for what slow noise may do."""
    ex, rules = examination, examination.setting.rules.search
    above = ex.over_floor_in_bands(base) > np.maximum(1 + rules.band_stands_out, ex.most_in_bands)
    return above & ~bands_standing_out(ex, base)
