"""Output error in closed loop: the parameters whose simulation comes nearest to the log.

No derivative of a measured signal is taken, so sensor noise biases nothing. An encoder's noise moves the arm
through the loop; the covariance follows from the spectrum of all that the simulation misses. The simulated
outputs are linearised in the parameters along the directions that the regression saw (Gauss-Newton); a good
start is needed and comes from `auxiliary_model`.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.estimation.identify import Identified, identified
from pyident.estimation.instrumental_variables import Rows, solve_instrumental, spectral
from pyident.estimation.least_squares import Solution, solve
from pyident.estimation.physical import lower_bounds
from pyident.logs.log import Log
from pyident.regression.reduced import Reduced, reduce
from pyident.simulation.replay import Progress, Replay, replay_of
from pyident.simulation.simulator import Simulate

NAME = "output error in closed loop"
_STEP = 1e-6  # of the length of the scaled parameters: finite difference
_ROUNDS = 12  # every second one renews the slopes
_SETTLED = 5e-2  # of a standard deviation: change at which the rounds end
_FLOOR = 1e-9  # of a channel's rms: its least noise


def output_error(
    robot: Robot,
    logs: list[Log],
    start: Identified,
    simulate: Simulate,
    slopes: list[np.ndarray] | None = None,
    progress: Progress | None = None,
) -> tuple[Identified, list[np.ndarray]]:
    """Improve `start` until its simulation no longer comes nearer to the logs.

    slopes   d(outputs)/d(parameters) per log, (N, channels, P), of an earlier call on the same motion
    Raises LogError when a log has no reference.
    """
    replays = [replay_of(start.robot, log) for log in logs]
    best, given = start, slopes
    for number in range(_ROUNDS):
        renewed = given is None and number % 2 == 0
        if renewed:
            p = _operating_point(best)
            share = _share(progress, number)
            slopes = [_slopes(replay, p, start.solution, simulate, share) for replay in replays]
        assert slopes is not None
        p = best.robot.linear_parameters
        missed = [r.missed(next(iter(r.run(simulate, [p])))) for r in replays]
        reduced = _linearised(replays[0].channels, p, missed, slopes)
        solution = solve(reduced, _weights(missed, replays))
        solution = replace(solution, covariance=_coloured(solution, reduced, p, missed, slopes))
        change = np.abs(solution.p - np.array(list(p.values())))[~solution.open]
        best = replace(
            identified(robot, reduced, solution),
            relative_error=start.relative_error,
            estimator=NAME,
            notes=start.notes,
        )
        settled = (change <= _SETTLED * solution.std[~solution.open]).all()
        if settled and (renewed or given is not None):  # old slopes may settle beside the optimum
            break
    assert slopes is not None
    return best, slopes


def _share(progress: Progress | None, number: int) -> Progress | None:
    return None if progress is None else lambda fraction: progress((number + fraction) / _ROUNDS)


def _operating_point(found: Identified) -> dict[str, float]:
    """The parameters, with those that must not be negative two finite differences away from zero."""
    scale = dict(zip(found.reduced.columns, found.solution.scale, strict=True))
    length = float(np.linalg.norm(found.solution.p * found.solution.scale))
    bounds = lower_bounds(found.robot)
    floors = {name: 2 * _STEP * length / scale[name] for name, lower in bounds.items() if lower == 0}
    return {
        name: max(value, floors.get(name, -np.inf)) for name, value in found.robot.linear_parameters.items()
    }


def _slopes(
    replay: Replay,
    p: Mapping[str, float],
    regression: Solution,
    simulate: Simulate,
    progress: Progress | None,
) -> np.ndarray:
    """Forward differences along every direction that the regression saw; zero along the others."""
    values, scale = np.array(list(p.values())), regression.scale
    step = _STEP * float(np.linalg.norm(regression.p * scale))
    directions = regression.seen.T
    sets = [dict(zip(p, values + step * d / scale, strict=True)) for d in directions]
    runs = iter(replay.run(simulate, [p, *sets]))
    base = replay.missed(next(runs))
    slopes = np.empty((*base.shape, len(directions)))
    for i, frame in enumerate(runs):
        slopes[:, :, i] = (base - replay.missed(frame)) / step
        if progress:
            progress((i + 1) / len(directions))
    return (slopes @ directions) * scale


def _linearised(
    channels: tuple[str, ...], p: Mapping[str, float], missed: list[np.ndarray], slopes: list[np.ndarray]
) -> Reduced:
    values = np.array(list(p.values()))
    blocks = ((s, m + s @ values) for m, s in zip(missed, slopes, strict=True))
    return reduce(blocks, channels, tuple(p))


def _coloured(
    solution: Solution,
    reduced: Reduced,
    p: Mapping[str, float],
    missed: list[np.ndarray],
    slopes: list[np.ndarray],
) -> np.ndarray:
    """Covariance under what the noise of the sensors makes of the motion, on its way through the loop."""
    values = np.array(list(p.values()))
    rows = [Rows(s, s, m + s @ values, np.ones_like(m)) for m, s in zip(missed, slopes, strict=True)]
    scatter = spectral(lambda: rows, solution.weights)
    return solve_instrumental(lambda: rows, reduced, solution.weights, scatter, solution.rank).covariance


def _weights(missed: list[np.ndarray], replays: list[Replay]) -> np.ndarray:
    """One over each channel's noise, taken to be what the start misses."""
    noise = np.sqrt(np.mean(np.concatenate(missed) ** 2, axis=0))
    signal = np.sqrt(np.mean(np.concatenate([r.measured for r in replays]) ** 2, axis=0))
    return 1 / np.maximum(noise, _FLOOR * np.maximum(signal, 1e-12))
