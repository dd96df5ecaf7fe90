"""Intervals of output error: the fitted robot with noise in its sensors, and what a log misses beyond that.

An encoder's noise moves the arm through the loop, and friction makes that motion very uneven: near reversals
its slow part has a thousand times the power that it has elsewhere. The spectrum of a whole log does not tell
that, and what a fit of 70 parameters leaves has lost most of it. So the fitted robot is simulated with the
noise of its sensors, and each such log is estimated as the log was, to first order. What the log misses
beyond that noise, at a frequency of a channel, counts by its spectrum.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot
from pyident.estimation.instrumental_variables import Rows, solve_instrumental
from pyident.estimation.least_squares import Solution
from pyident.logs.log import Log
from pyident.refinement.instruments.residual_spectrum import beyond_noise, smoothed_power, spectral
from pyident.regression.reduced import Reduced
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.noise.sensor_noise import sensor_noise
from pyident.simulation.replay import Replay
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Pool, Simulator, runs_at_once

_REPLICAS = 32  # of each log


@dataclass(frozen=True)
class Outputs:
    """A log's outputs, linear in the parameters p (P,) near the fitted ones: slopes @ p.

    slopes   (N, channels, P);  target (N, channels): what they are to be
    """

    replay: Replay
    slopes: np.ndarray
    target: np.ndarray

    @property
    def rows(self) -> Rows:
        """As equations that are their own instruments."""
        return Rows(self.slopes, self.slopes, self.target, np.ones_like(self.target))


def output_covariance(
    robot: Robot, outputs: Sequence[Outputs], reduced: Reduced, solution: Solution, pool: Pool
) -> np.ndarray:
    """(P, P) of the `solution` of the outputs; reduced: what they were folded into; robot: fitted."""
    from scipy.stats import t

    noise = sensor_noise(robot, [output.replay.log for output in outputs], solution.p)
    moments, beyond = np.zeros((_REPLICAS, len(solution.p))), []
    for output in outputs:
        power = np.zeros(())
        for number, change in enumerate(_changes(robot, output.replay, noise, pool)):
            moments[number] += np.einsum("ncp,nc->p", output.slopes, solution.weights**2 * change)
            power = power + smoothed_power(change) / _REPLICAS
        beyond.append(beyond_noise(smoothed_power(output.rows.residual(solution.p)), power))
    inverse = solution.seen / solution.singular_values[: solution.rank] ** 2 @ solution.seen.T
    errors = moments / solution.scale @ inverse / solution.scale
    wider = float(t.ppf(0.975, _REPLICAS)) / CONFIDENCE  # few draws tell a standard deviation roughly
    rows = [output.rows for output in outputs]
    scatter = spectral(lambda: rows, solution.weights, beyond)
    rest = solve_instrumental(lambda: rows, reduced, solution.weights, scatter, solution.rank)
    return wider**2 * errors.T @ errors / _REPLICAS + rest.covariance


def _changes(robot: Robot, replay: Replay, noise: dict[str, float], pool: Pool) -> Iterator[np.ndarray]:
    """(N, channels) of each replica: what noise makes of the outputs."""
    p, repeat = robot.linear_parameters, replay.repeat
    together = runs_at_once(len(replay.plan.time))
    jobs = [
        pool.submit(_replicas, repeat, p, noise, range(at, min(at + together, _REPLICAS)))
        for at in range(0, _REPLICAS, together)
    ]
    quiet = replay.missed(next(iter(replay.run(pool, [p]))))
    for job in jobs:
        for log in job.result():
            yield quiet - replay.missed(log.frame)


def _replicas(
    simulator: Simulator,
    repeat: Repeat,
    parameters: Mapping[str, float],
    noise: Mapping[str, float],
    seeds: Sequence[int],
) -> list[Log]:
    return repeat.replicas(simulator, parameters, noise, seeds)
