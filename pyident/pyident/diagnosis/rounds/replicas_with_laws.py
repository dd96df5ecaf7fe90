"""Replicas of a model with laws that a robot lacks, and the floors that they make for a search without."""

from collections.abc import Callable, Sequence, Set
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np

from pyident.diagnosis.base.candidates import Candidate, Family, every_law, with_law
from pyident.diagnosis.base.residual_over_floor import Examination, examine
from pyident.diagnosis.base.ringing_hinges import with_ringing_matched
from pyident.diagnosis.base.setting import Setting, set_up, unbiased, workers_of
from pyident.diagnosis.search.search import search_of
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]


def replicated(
    setting: Setting,
    laws: Sequence[Candidate],
    open_pool: OpenPool,
    progress: Progress,
    families: Set[Family] | None = None,
) -> Examination:
    """The logs, and replicas of a model with laws, under that model, and candidates of families; none: all.

    Raises LogError, SimulationError.
    """

    def listed(*asked: Any) -> list[Candidate]:
        return [c for c in every_law(*asked) if families is None or c.family in families]

    robot = reduce(with_law, laws, setting.robot)
    having = set_up(robot, setting.logs, setting.rules, setting.estimator, setting.alignment)
    with workers_of(having, open_pool) as workers:
        free = with_ringing_matched(unbiased(having, workers), workers)
        return examine(free, workers, progress, listed)


def over_floors_of(ex: Examination, having: Examination) -> Examination:
    """An examination whose replicas leave no less, on any equation and in any band, than others do.

    having   the same logs' under another model
    """
    count = np.maximum(sum(inside.sum(axis=0) for inside in ex.bands), 1)
    pairs = zip(having.levels, ex.levels, ex.bands, strict=True)
    unit = sum(np.square(theirs / own) @ inside for theirs, own, inside in pairs) / count
    return _raised(ex, having.replica_energy.mean(axis=0) * unit)


def beside_laws(ex: Examination, laws: Sequence[Candidate], having: Examination) -> Examination:
    """An examination in which laws leave as many floors as the logs leave of a model's that has them.

    That model is fitted by simulation, and makes less of what a law's values are off.
    """
    beside = search_of(ex).resting_on(laws).base
    left = ex.by_band(beside.residual).sum(axis=0) / np.maximum(ex.count, 1)
    ratio = having.energy / np.maximum(having.replica_energy.mean(axis=0), 1e-300)
    return _raised(ex, left / np.maximum(ratio, 1e-300))


def _raised(ex: Examination, least: np.ndarray) -> Examination:
    """An examination whose replicas leave no less than that (n, bands), as a mean square over the floor."""
    times = np.maximum(least / np.maximum(ex.replica_energy.mean(axis=0), 1e-300), 1.0)
    sizes = [np.sqrt(np.where(inside.any(axis=1), times @ inside.T, 1.0)) for inside in ex.bands]
    residuals = [[r * size for r, size in zip(made, sizes, strict=True)] for made in ex.replica_residuals]
    return replace(ex, replica_energy=ex.replica_energy * times, replica_residuals=residuals)
