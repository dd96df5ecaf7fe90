"""A long log conditioned window by window, to the same numbers as in one go.

Differences and means reach a few samples, filters until their start is forgotten: every window is read with
such a margin. What looks at the whole log, how fast parts slide on each other, comes from a first pass.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.filters import settling, thinning_filter
from pyident.conditioning.reversals.rubbing import speed_products
from pyident.conditioning.samples import Conditioned, Piece
from pyident.conditioning.weak_form import REACH, Recipe, condition, recipe
from pyident.logs.disk import ROWS, LogFile
from pyident.logs.log import Log, read_log


@dataclass(frozen=True)
class ConditionedFile:
    """A log on disk and what becomes of it. products: of the joints' speeds, as of `speed_products`."""

    log: LogFile
    recipe: Recipe
    products: np.ndarray

    @property
    def thinning(self) -> int:
        return self.recipe.robot.settings.processing.decimate

    def pieces(self) -> Iterator[Piece]:
        """All samples in order, window by window; the first own sample is one that thinning keeps."""
        for part, own in _windows(self.log, self.recipe, self.thinning):
            yield Piece(self.recipe.masked(part, self.products), own)


def prepared(log: Log | LogFile, robot: Robot) -> Conditioned | ConditionedFile:
    """The log as equations; a log on disk stays there unless a law remembers. Raises LogError."""
    if isinstance(log, LogFile) and _remembers(robot):
        log = read_log(log.path, log.columns)
    if isinstance(log, Log):
        return condition(log, robot)
    plan, joints = recipe(log, robot), len(robot.joints)
    total, samples = np.zeros((joints, joints)), 0
    for part, own in _windows(log, plan, 1):
        dq = part.motion.dq[own]
        total, samples = total + len(dq) * speed_products(dq, joints), samples + len(dq)
    return ConditionedFile(log, plan, total / samples)


def _remembers(robot: Robot) -> bool:
    """Whether a law has states: they follow from the whole log before a sample, not from a window."""
    return any(effect.states for joint in robot.joints for effect in joint.effects)


def _windows(log: LogFile, plan: Recipe, thinning: int) -> Iterator[tuple[Conditioned, slice]]:
    """Aligned samples and which of them are the window's own; the first one is one that thinning keeps.

    Samples are numbered without those that the log's start loses, as `condition` returns them.
    """
    lost = REACH + plan.border
    total = len(log) - 2 * lost
    margin = plan.mask_reach if thinning == 1 else _multiple(settling(thinning_filter(thinning)), thinning)
    size = _multiple(max(ROWS, 2 * margin), thinning)
    for window in log.windows(plan.names, size, lost + margin + plan.reach):
        start, stop = (window.first + row for row in (window.own.start, window.own.stop))
        stop = min(stop, total)
        if start < stop:
            begin, end = max(start - margin, 0), min(stop + margin, total)
            number = window.first - plan.border  # of the first aligned sample
            part = plan.aligned(window.values).cut(slice(begin - number, end - number))
            yield part, slice(start - begin, stop - begin)


def _multiple(least: int, factor: int) -> int:
    return -(-least // factor) * factor
