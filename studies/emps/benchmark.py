"""The model for a record that is not here: structure and parameters from one record, by parts held out of it.

Every candidate is fitted in free run from the voltage to parts of the record and judged on the others: each
half by the other, which tells what it extrapolates, and each quarter by the remaining three. Among the
candidates whose mean error is within one standard error of the least, the one with the fewest parameters is
taken and fitted to the whole record.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flexmodels.robot import Robot
from pyident.logs.log import Log
from pyident.simulation.free_run import plant_of

from .structures import STRUCTURES, Part, Structure, fit, parts_of, rms


@dataclass(frozen=True)
class Judged:
    """A structure, its robot fitted to the whole record, and free-run errors [mm].

    trained   on the record that it was fitted to;  heldout   on each part held out of the fit
    """

    structure: Structure
    robot: Robot
    trained: float
    heldout: tuple[float, ...]

    @property
    def error(self) -> float:
        return float(np.mean(self.heldout))

    @property
    def size(self) -> int:
        return len(self.structure.scale)


def folds(samples: int) -> list[tuple[list[Part], Part]]:
    """(parts to fit, part to judge): the two halves, then the four quarters."""
    half, quarters = samples // 2, [samples * i // 4 for i in range(5)]
    listed: list[tuple[list[Part], Part]] = [
        ([(0, half)], (half, samples)),
        ([(half, samples)], (0, half)),
    ]
    for first, last in pairwise(quarters):
        listed.append(([(0, first), (last, samples)], (first, last)))
    return listed


def judged(
    robot: Robot, log: Log, start: Mapping[str, float], progress: Callable[[float], None]
) -> list[Judged]:
    """Every structure; start: parameters from which all set out, of the record itself."""
    results = []
    for number, structure in enumerate(STRUCTURES, start=1):
        results.append(_judge(structure, robot.with_parameters(start), log))
        progress(number / len(STRUCTURES))
    return results


def simplest(results: list[Judged]) -> Judged:
    """The one with the fewest parameters within a standard error of the best."""
    best = min(results, key=lambda r: r.error)
    limit = best.error + float(np.std(best.heldout, ddof=1) / np.sqrt(len(best.heldout)))
    return min((r for r in results if r.error <= limit), key=lambda r: (r.size, r.error))


def _judge(structure: Structure, robot: Robot, log: Log) -> Judged:
    candidate = structure.of(robot)
    with plant_of(candidate) as plant:
        whole = parts_of(candidate, log, [(0, len(log))])
        values = fit(structure, candidate, whole, plant)
        fitted = candidate.with_parameters(values)
        errors = []
        for parts, unseen in folds(len(log)):
            seen = fit(structure, fitted, parts_of(candidate, log, parts), plant)
            errors.append(rms(candidate, seen, parts_of(candidate, log, [unseen]), plant))
        return Judged(structure, fitted, rms(candidate, values, whole, plant), tuple(errors))
