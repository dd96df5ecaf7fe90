"""Who has to keep the limits before a plan may be given to a machine."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.excitation.capsules import Geometry
from pyident.excitation.limits import Limits
from pyident.excitation.rehearsals.rehearsal import Rehearsal, others_like, violations
from pyident.excitation.rehearsals.violations import slack

_REHEARSED = 48  # robots with every parameter off by the most, up or down
_DEVIATIONS = 4.0  # by which the others must stay from a limit on average: one of thousands may come there
_AT_ONCE = 8  # robots that rehearse, before it is asked whether the others still have to


class Jury:
    """Those who rehearse: the robot first, its rivals, and others whose parameters are off by `spread`."""

    def __init__(
        self,
        robot: Robot,
        limits: Limits,
        geometry: Geometry,
        rehearsals: Sequence[Rehearsal],
        spread: float,
    ):
        self.robot, self.limits, self.geometry, self.rehearsals = robot, limits, geometry, rehearsals
        self.others = others_like(robot, _REHEARSED, seed=1, spread=spread, least=1.0)

    def broken(self, plan: Experiment) -> str:
        """What somebody breaks, or might; empty where all keep the limits by more than they differ."""
        left: list[pd.Series] = []
        try:
            for one in self.rehearsals:
                if found := violations(one, self.limits, self.geometry, plan):
                    return f"the {found[0].what} of {found[0].where}"
            for first in range(0, len(self.others), _AT_ONCE):
                called = self.others[first : first + _AT_ONCE]
                frames = self.rehearsals[0].others(plan, called)
                left += [slack(self.robot, self.limits, self.geometry, frame) for frame in frames]
                worst = int(np.argmin([of.min() for of in left]))
                if left[worst].min() < 0:
                    self.others.insert(
                        0, self.others.pop(worst)
                    )  # who broke a limit is asked first next time
                    return str(left[worst].idxmin())
        except SimulationError:
            return "the simulation's step"
        table = pd.DataFrame(left)
        margin = table.mean() - _DEVIATIONS * table.std(ddof=0)
        return str(margin.idxmin()) if margin.min() < 0 else ""
