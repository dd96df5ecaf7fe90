"""A simulation that follows the logs, or the farthest step towards parameters under which one does.

Early rounds may ask for damping that holds no loop, while all else they find is right: a step that leads to a
simulation which fails, or goes elsewhere, is halved.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.estimation.identify import soft_hinges
from pyident.estimation.least_squares import Solution
from pyident.estimation.physical import consistent
from pyident.logs.log import LogError
from pyident.refinement.instruments.missed import NotFollowedError, require_followed
from pyident.refinement.instruments.simulated_rows import simulable, simulations
from pyident.refinement.instruments.starts import Begun
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Workers

_SHORTEST = 1 / 16  # of a step


@dataclass(frozen=True)
class Followed:
    """What a simulation follows the logs with.

    wanted   the robot of a step;  share of the step that was gone
    put_in   its parameters that can be simulated;  frames: each log's motion under them
    """

    wanted: Robot
    share: float
    put_in: dict[str, float]
    frames: list[pd.DataFrame]


@dataclass(frozen=True)
class Followers:
    """What makes the logs of a start again."""

    start: Begun
    again: Sequence[Repeat]
    workers: Workers
    prior: Robot | None

    def towards(self, wanted: Robot, found: Solution, before: Robot | None) -> Followed:
        """The simulation under wanted parameters, or nearer to those before, if there are any.

        Raises SimulationError, NotFollowedError.
        """
        share, aim = 1.0, wanted.linear_parameters
        while True:
            try:
                return Followed(wanted, share, *self._simulated(wanted, found))
            except (SimulationError, NotFollowedError):
                if before is None or share <= _SHORTEST:
                    raise
            share /= 2
            begin = before.linear_parameters
            wanted = before.with_parameters({n: v + share * (aim[n] - v) for n, v in begin.items()})

    def _simulated(self, wanted: Robot, found: Solution) -> tuple[dict[str, float], list[pd.DataFrame]]:
        """The parameters nearest those wanted that can be simulated, and each log's motion under them."""
        robot, reduced = self.start.robot, self.start.plain.reduced
        names, values = reduced.columns, np.array(list(wanted.linear_parameters.values()))
        hinges = {} if self.prior is None else soft_hinges(names, replace(found, p=values), self.prior)
        quiet = simulable(robot, names, values, hinges)
        put_in = wanted.parameters | dict(zip(names, quiet.tolist(), strict=True))
        try:
            return self._following(put_in)
        except (SimulationError, NotFollowedError) as error:
            try:
                possible = consistent(robot, reduced, replace(found, p=quiet), self.prior)
            except LogError:  # far from all that can be
                raise error from None
            put_in |= dict(zip(names, possible.tolist(), strict=True))
            return self._following(put_in)

    def _following(self, put_in: dict[str, float]) -> tuple[dict[str, float], list[pd.DataFrame]]:
        put_in, frames = simulations(self.again, self.workers, put_in)
        require_followed(self.again, frames)
        return put_in, frames
