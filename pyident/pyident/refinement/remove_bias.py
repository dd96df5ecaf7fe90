"""What the regression itself does wrong, taken away: indirect inference (Gourieroux et al. 1993).

A regression on sampled signals is biased: differences are not derivatives, held torques are not sampled ones.
The bias is measured instead of argued about. The model found is simulated over the log's own reference, the
same regression is run on this replica, and what it finds there is compared with what was put in:

    p  ←  p + (found in the log − found in the replica of p).

At the fixed point the replica looks to the regression exactly as the log does. One simulation a round.
What sensor noise itself biases stays; `output_error` removes it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import weighted
from pyident.estimation.identify import Identified, identified
from pyident.estimation.least_squares import Solution
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.simulation.replay import Progress, Replay, replay_of
from pyident.simulation.simulator import Simulate

_ROUNDS = 20
_SETTLED = 0.1  # of a standard deviation: change at which the rounds end


def correct_by_replicas(
    robot: Robot, logs: list[Log], simulate: Simulate, progress: Progress | None = None
) -> Identified:
    """Identify `robot` and remove the regression's bias. Raises LogError."""
    parts = tuple(condition(log, robot) for log in logs)
    found = weighted(Problem(robot, parts)).with_long_memory()
    reduced, in_log = found.reduced, found.solution
    best = identified(robot, reduced, in_log)
    replays = [replay_of(best.robot, log) for log in logs]
    for number in range(_ROUNDS):
        put_in = best.robot.linear_parameters
        problem = _replica(robot, replays, parts, put_in, simulate)
        step = seen(in_log, in_log.p - weighted(problem, in_log).solution.p)
        values = np.array(list(put_in.values())) + step
        change = np.abs(seen(in_log, values - best.solution.p))[~in_log.open]
        best = identified(robot, reduced, replace(in_log, p=values))
        if progress:
            progress((number + 1) / _ROUNDS)
        if (change <= _SETTLED * in_log.std[~in_log.open]).all():
            break
    return best


def _replica(
    robot: Robot,
    replays: list[Replay],
    parts: Sequence[Conditioned],
    parameters: dict[str, float],
    simulate: Simulate,
) -> Problem:
    """The problem that the logs would have posed had the robot had these parameters; same equations used."""
    made = []
    for replay, part in zip(replays, parts, strict=True):
        frame = next(iter(replay.run(simulate, [parameters])))
        made.append(replace(condition(Log(frame, "replica"), robot), use=part.use, free=part.free))
    return Problem(robot, tuple(made))


def seen(solution: Solution, change: np.ndarray) -> np.ndarray:
    """(P,) the part of a change of parameters that the data see."""
    return solution.seen @ (solution.seen.T @ (change * solution.scale)) / solution.scale
