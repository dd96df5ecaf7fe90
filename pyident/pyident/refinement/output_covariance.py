"""Intervals of output error: the fitted robot with noise in its sensors, and what a log misses beyond that.

An encoder's noise moves the arm through the loop, and friction makes that motion very uneven: near reversals
its slow part has a thousand times the power that it has elsewhere. The spectrum of a whole log does not tell
that, and what a fit of 70 parameters leaves has lost most of it. So the fitted robot is simulated with the
noise of its sensors, and each such log is estimated as the log was, to first order. What the log misses
beyond that noise, at a frequency of a channel, counts by its spectrum.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot
from pyident.estimation.instrumental_variables import Rows, smoothed_power, solve_instrumental, spectral
from pyident.estimation.least_squares import Solution
from pyident.regression.reduced import Reduced
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.replay import Replay
from pyident.simulation.sensor_noise import sensor_noise
from pyident.simulation.simulator import Pool, Simulator, runs_at_once

_REPLICAS = 32  # of each log
_LANES = 16  # runs of one task, of short logs
_EXCESS = 1.2  # times what noise leaves of a channel at a frequency: more is not noise alone


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
        ratio = smoothed_power(output.rows.residual(solution.p)) / np.maximum(power, 1e-300)
        beyond.append(np.where(ratio < _EXCESS, 0.0, np.sqrt(1 - 1 / np.maximum(ratio, 1.0))))
    inverse = solution.seen / solution.singular_values[: solution.rank] ** 2 @ solution.seen.T
    errors = moments / solution.scale @ inverse / solution.scale
    wider = float(t.ppf(0.975, _REPLICAS)) / CONFIDENCE  # few draws tell a standard deviation roughly
    rows = [output.rows for output in outputs]
    scatter = spectral(lambda: rows, solution.weights, beyond)
    rest = solve_instrumental(lambda: rows, reduced, solution.weights, scatter, solution.rank)
    return wider**2 * errors.T @ errors / _REPLICAS + rest.covariance


def _changes(robot: Robot, replay: Replay, noise: dict[str, float], pool: Pool) -> Iterator[np.ndarray]:
    """(N, channels) of each replica: what noise makes of the outputs."""
    together = runs_at_once(len(replay.plan.time), _LANES)
    jobs = [
        pool.submit(_noisy, robot, replay, noise, range(at, min(at + together, _REPLICAS)))
        for at in range(0, _REPLICAS, together)
    ]
    for job in jobs:
        yield from job.result()


def _noisy(
    simulator: Simulator, robot: Robot, replay: Replay, noise: dict[str, float], seeds: Sequence[int]
) -> list[np.ndarray]:
    p = robot.linear_parameters
    quiet = replay.missed(replay.inputs.cut(simulator.simulate(replay.plan, p)))
    frames = simulator.simulate_batch(replay.plan, [p], noise, seeds)
    return [quiet - replay.missed(replay.inputs.cut(frame)) for frame in frames]
