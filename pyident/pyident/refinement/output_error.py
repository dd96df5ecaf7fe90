"""Output error in closed loop: the parameters whose simulation comes nearest to the log.

No derivative of a measured signal is taken, so sensor noise biases nothing. An encoder's noise moves the arm
through the loop; what that does to the estimate, `output_covariance` simulates. The simulated outputs are
linearised in the parameters along the directions that the regression saw, and of each step the length is
tried (Gauss and Newton, with a search along the line); a good start is needed, from `auxiliary_model`. Slopes
cost a simulation a direction, a step one a length: slopes serve as long as the steps shrink.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.estimation.identify import Identified, identified, relative_error
from pyident.estimation.least_squares import Solution, solve
from pyident.estimation.physical import lower_bounds
from pyident.logs.log import Log
from pyident.refinement.output_covariance import Outputs, output_covariance
from pyident.regression.reduced import reduce
from pyident.simulation.replay import Progress, Replay, replay_of
from pyident.simulation.simulator import Pool

NAME = "output error in closed loop"
_STEP = 1e-6  # of the length of the scaled parameters: finite difference
_ROUNDS = 24
_SETTLED = 0.1  # of a standard deviation under white noise: change at which the rounds end
_SHARES = (1.0, 0.7, 0.5, 0.35, 0.25, 0.12, 0.06)  # of a step: it may lead too far, as friction sticks
_KEPT = 0.5  # of the step before: a step by slopes taken earlier is as good as one by new ones
_FLOOR = 1e-9  # of a channel's rms: its least noise
_UNSETTLED = f"output error had not settled after {_ROUNDS} rounds; its intervals may be too narrow"


def output_error(
    robot: Robot, logs: Sequence[Log], start: Identified, pool: Pool, progress: Progress | None = None
) -> Identified:
    """Improve `start` until its simulation no longer comes nearer to the logs.

    Raises LogError when a log has no reference.
    """
    replays = [replay_of(start.robot, log) for log in logs]
    # the start's instruments are filtered: steps are measured by the log's own columns
    start = replace(start, solution=solve(start.reduced, start.solution.weights))
    best, outputs, settled = _approach(robot, replays, start, pool, progress)
    covariance = output_covariance(best.robot, outputs, best.reduced, best.solution, pool)
    found = identified(robot, best.reduced, replace(best.solution, covariance=covariance))
    return replace(
        found,
        relative_error=relative_error(start.reduced, found.solution.p, len(robot.joints)),
        estimator=NAME,
        notes=start.notes if settled else (*start.notes, _UNSETTLED),
    )


def _approach(
    robot: Robot, replays: Sequence[Replay], start: Identified, pool: Pool, progress: Progress | None
) -> tuple[Identified, list[Outputs], bool]:
    """Rounds of steps from `start`, by slopes that are taken anew once steps by the old ones fail to shrink.

    Returns the parameters, the outputs linearised near them, and whether the steps had settled.
    """
    p, missed = _nearest(replays, [_simulable(start, start)], pool)
    best, outputs, slopes, last = start, [], [], np.inf
    for number in range(_ROUNDS):
        fresh = not slopes
        if fresh:
            told = [_share(progress, number + k / len(replays), len(replays)) for k in range(len(replays))]
            slopes = [
                _slopes(r, p, m, start.solution, pool, t)
                for r, m, t in zip(replays, missed, told, strict=True)
            ]
        values = np.array(list(p.values()))
        outputs = [Outputs(r, s, m + s @ values) for r, s, m in zip(replays, slopes, missed, strict=True)]
        reduced = reduce(((o.slopes, o.target) for o in outputs), replays[0].channels, tuple(p))
        best = identified(robot, reduced, solve(reduced, _weights(missed, replays)))
        step = np.array(list(_simulable(best, start).values())) - values
        length = _length(step, best)
        if length <= _SETTLED:
            return best, outputs, True
        tried = [dict(zip(p, values + share * step, strict=True)) for share in _SHARES]
        nearer, left = _nearest(replays, tried, pool)
        falls = _distance(left, replays) < _distance(missed, replays)
        if fresh and not falls:
            return best, outputs, True
        if not falls or (not fresh and length > _KEPT * last):
            slopes = []
        if falls:
            p, missed, last = nearer, left, length
    return best, outputs, False


def _nearest(
    replays: Sequence[Replay], sets: Sequence[dict[str, float]], pool: Pool
) -> tuple[dict[str, float], list[np.ndarray]]:
    """The parameters under which the logs are likeliest, and per log what they miss (N, channels)."""
    missed = zip(*([r.missed(frame) for frame in r.run(pool, sets)] for r in replays), strict=True)
    p, left = min(zip(sets, missed, strict=True), key=lambda pair: _distance(pair[1], replays))
    return p, list(left)


def _distance(missed: Sequence[np.ndarray], replays: Sequence[Replay]) -> float:
    """Falls as the logs become likelier."""
    return -float(np.log(_weights(missed, replays)).sum())


def _length(step: np.ndarray, found: Identified) -> float:
    """Largest step of a parameter that stands alone, in its standard deviations."""
    alone = ~found.solution.open
    return float(np.max(np.abs(step[alone]) / found.solution.std[alone], initial=0.0))


def _share(progress: Progress | None, rounds: float, logs: int) -> Progress | None:
    """Progress within one log of a round; rounds: done before it."""
    return progress and (lambda fraction: progress((rounds + fraction / logs) / _ROUNDS))


def _simulable(found: Identified, start: Identified) -> dict[str, float]:
    """The parameters, with those that must not be negative two finite differences away from zero."""
    scale = dict(zip(start.reduced.columns, start.solution.scale, strict=True))
    least = 2 * _STEP * float(np.linalg.norm(start.solution.p * start.solution.scale))
    floors = {name: least / scale[name] for name, bound in lower_bounds(found.robot).items() if bound == 0}
    return {
        name: max(value, floors.get(name, -np.inf)) for name, value in found.robot.linear_parameters.items()
    }


def _slopes(
    replay: Replay,
    p: Mapping[str, float],
    missed: np.ndarray,
    regression: Solution,
    pool: Pool,
    progress: Progress | None,
) -> np.ndarray:
    """Forward differences along every direction that the regression saw; zero along the others.

    missed   (N, channels) under p itself
    """
    values, scale = np.array(list(p.values())), regression.scale
    step = _STEP * float(np.linalg.norm(regression.p * scale))
    directions = regression.seen.T
    sets = [dict(zip(p, values + step * d / scale, strict=True)) for d in directions]
    slopes = np.empty((*missed.shape, len(directions)))
    for i, frame in enumerate(replay.run(pool, sets)):
        slopes[:, :, i] = (missed - replay.missed(frame)) / step
        if progress:
            progress((i + 1) / len(directions))
    return (slopes @ directions) * scale


def _weights(missed: Sequence[np.ndarray], replays: Sequence[Replay]) -> np.ndarray:
    """One over each channel's noise, taken to be what is missed: (N, channels) per log."""
    noise = np.sqrt(np.mean(np.concatenate(missed) ** 2, axis=0))
    signal = np.sqrt(np.mean(np.concatenate([r.measured for r in replays]) ** 2, axis=0))
    return 1 / np.maximum(noise, _FLOOR * np.maximum(signal, 1e-12))
