"""The robot's own experiment with its measures as numbers: how far each joint swings, how loud, how quick.

The variants of the experiment that are at hand without a search are members of this family, so that the best
of its members is worth no less than any of them.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmodels.experiment import Experiment, identification
from pyident.excitation.drawing import Drawing
from pyident.excitation.fourier import Reference
from pyident.excitation.task import Task
from pyident.excitation.variants import LARGER, SMALLER, at_rest

_QUICKEST, _SLOWEST = 4.0, 0.05  # of the experiment's pace


@dataclass(frozen=True)
class Tuned:
    """Motions by 2 joints + 1 numbers: factors of every joint's swing and multisine, then of the pace."""

    drawing: Drawing

    @classmethod
    def of(cls, task: Task, drawing: Drawing) -> "Tuned | None":
        """None where the robot has no experiment, or no loop that follows it."""
        if task.robot.settings.identification is None or task.robot.controller is None:
            return None
        return cls(drawing)

    @property
    def starts(self) -> list[np.ndarray]:
        """The experiment, slower, with more or less multisine, joint by joint."""
        joints = len(self.drawing.task.robot.joints)
        whole = np.ones(2 * joints + 1)
        found = [whole]
        for pace in (0.5, 0.25):
            found.append(np.append(whole[:-1], pace))
        for share in (LARGER, SMALLER, 0.0):
            found.append(np.concatenate([np.ones(joints), np.full(joints, share), [1.0]]))
        for k in range(joints if joints > 1 else 0):
            alone = np.tile(np.arange(joints) == k, 2).astype(float)
            found.append(np.append(alone, 1.0))
        return found

    def plan(self, z: np.ndarray) -> Experiment | None:
        """As large as the limits allow; None where not even a small one is allowed."""
        task = self.drawing.task
        coarse = slice(None, None, max(1, round(task.rate / 50)))
        plan = self._asked(z)
        home = task.limits.home

        def made(scale: float) -> Reference:
            time, q = plan.time[coarse], home + scale * (plan.reference[coarse] - home)
            dq = np.gradient(q, time, axis=0)
            return Reference(time, q, dq, np.gradient(dq, time, axis=0))

        scale = self.drawing.largest(made)
        if scale is None:
            return None
        return Experiment(plan.time, home + scale * (plan.reference - home), plan.feedforward)

    @cached_property
    def _way(self) -> Experiment:
        """The experiment, for as long as the quickest motion needs it."""
        task = self.drawing.task
        return identification(task.robot, duration=_QUICKEST * task.duration)

    def _asked(self, z: np.ndarray) -> Experiment:
        """Every joint's swing within what its limits of range, speed and acceleration allow by themselves."""
        task = self.drawing.task
        limits, joints = self.drawing.family.limits, len(task.robot.joints)
        time = np.arange(len(task.multisine)) / task.rate
        pace = float(np.clip(z[-1], _SLOWEST, _QUICKEST))
        way = np.column_stack([np.interp(pace * time, self._way.time, r) for r in self._way.reference.T])
        way = at_rest(Experiment(time, way - way[0], np.zeros_like(way))).reference
        speed = np.gradient(way, time, axis=0)
        sizes = [
            (way.max(axis=0), limits.upper - limits.home),
            (-way.min(axis=0), limits.home - limits.lower),
            (np.abs(speed).max(axis=0), limits.speed),
            (np.abs(np.gradient(speed, time, axis=0)).max(axis=0), limits.acceleration),
        ]
        most = np.min([allowed / np.maximum(size, 1e-12) for size, allowed in sizes], axis=0)
        swing = np.clip(z[:joints], 0, most)
        loud = np.clip(z[joints:-1], 0, task.loudest)
        return Experiment(time, limits.home + swing * way, loud * task.multisine)
