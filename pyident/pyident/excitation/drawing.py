"""Numbers become motions that a robot can run: as large as its limits, torques and distances allow."""

import functools
from collections.abc import Callable

import numpy as np

from flexmodels.experiment import Experiment
from pyident.excitation.followed import followed, torques
from pyident.excitation.fourier import Family, Reference
from pyident.excitation.rehearsals.violations import of_reference
from pyident.excitation.task import Task

SMALLEST = 0.05  # of the way from home: below, nothing is left of a motion
SHRINK = 0.92
_TORQUE_SHARE = 0.8  # of a torque limit, that a reference may use: the rest is for the loop
_NEARER = 1.25  # by which a motion shrinks whose links come too near
_COARSE = 50.0  # Hz at which candidates are judged


class Drawing:
    """Turns numbers into references that keep the limits, torques and distances included."""

    def __init__(self, task: Task):
        self.task, self.family = task, task.family
        self.waves = task.multisine * np.minimum(1.0, task.loudest)
        self.torque = _TORQUE_SHARE * (task.limits.torque - np.abs(self.waves).max(axis=0))

    @property
    def coarse(self) -> float:
        """Time between the samples [s] at which candidates are judged."""
        return 1 / min(_COARSE, self.task.rate)

    def starts(self, count: int) -> list[np.ndarray]:
        """Coefficients (joints, M) of random motions: those of `count` that may be run if smaller."""
        found = []
        for x in starts(self.family, count):
            coefficients = self.family.coefficients(x)
            made = functools.partial(self._motion, coefficients)
            if (scale := self.largest(made)) is not None:
                found.append(scale * coefficients)
        return found

    def _motion(self, coefficients: np.ndarray, scale: float) -> Reference:
        return self.family.motion(scale * coefficients, self.coarse)

    def reference(self, x: np.ndarray, step: float | None = None) -> Reference | None:
        """As large as it may be; None where not even a small one is allowed."""
        scale = self.largest(lambda scale: self.family.reference(x, self.coarse, scale))
        return None if scale is None else self.family.reference(x, step or self.coarse, scale)

    def largest(self, made: Callable[[float], Reference]) -> float | None:
        """The scale at which a motion keeps the limits, from 1 down; None where none of them does."""
        scale = 1.0
        while scale > SMALLEST:
            over = self._over(made(scale))
            if over <= 1:
                return scale
            scale *= max(0.5, min(SHRINK, 1 / over))
        return None

    def _over(self, reference: Reference) -> float:
        """Largest torque over what is allowed; more than one where links come too near."""
        robot = self.task.robot
        motion = followed(robot, reference.time, reference.q, reference.dq, reference.ddq)
        tau = motion.tau if motion.tau is not None else torques(robot, motion)
        worst = float((np.abs(tau).max(axis=0) / self.torque).max())
        if worst <= 1 and of_reference(robot, self.task.limits, self.task.geometry, reference):
            return _NEARER
        return worst

    def plan(self, reference: Reference, wave: float = 1.0) -> Experiment:
        """With the multisine."""
        return Experiment(reference.time, reference.q, wave * self.waves[: len(reference.time)])


def starts(family: Family, count: int) -> list[np.ndarray]:
    """Random members (size,) of the family, the same for the same count."""
    rng = np.random.default_rng(0)
    return [rng.standard_normal(family.size) for _ in range(count)]
