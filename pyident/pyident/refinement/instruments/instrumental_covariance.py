"""Intervals of the instrumental estimate: noise of the sensors, and motion that noise makes.

The noise of the sensors goes through the equations. What the residual has beyond it, at a frequency of an
equation, counts by its spectrum; all that it has, where nothing says what drives the joints: filters, clocks
and a friction that is a little different leave as much as the noise does, and in the same places. What the
simulation's samples and means owe to the estimate stands in the columns (`simulated_columns`). Dampings of
hinges that vibrate faster than the log is sampled get no interval: none that was tried held.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.conditioning.weak_form import condition
from pyident.estimation.instrumental_variables import MomentEquations, Rows
from pyident.estimation.least_squares import Solution
from pyident.refinement.instruments.logged import quiet
from pyident.refinement.instruments.noise_scatter import noise_scatter
from pyident.refinement.instruments.residual_spectrum import beyond_noise, of_fit, smoothed_power, spectral
from pyident.refinement.instruments.simulated_rows import Repeated, every, in_memory
from pyident.refinement.instruments.stand_in import driven
from pyident.regression.natural_frequencies import natural_frequencies
from pyident.regression.regressor import predicted
from pyident.simulation.noise.sensor_noise import sensor_noise

_FASTEST = 0.8  # of the Nyquist frequency: what vibrates faster is seen by its aliases only


def with_covariance(
    logs: Repeated, rows: list[Rows], equations: MomentEquations, solution: Solution
) -> Solution:
    """The noise of the sensors through the equations, and what there is beyond it by its spectrum."""
    robot = logs.robot
    if quiet(robot) or robot.settings.processing.filters:
        return equations.solve(of_fit(equations), solution.rank)
    noise = sensor_noise(robot, [r.log for r in logs.again], solution.p)

    def scatter(turn: np.ndarray, p: np.ndarray) -> np.ndarray:
        beyond = _beyond(logs, rows, p, noise) if driven(robot) else None
        total = spectral(every(rows), solution.weights, beyond)(turn, p)
        for d, r, a in zip(logs.data, rows, logs.again, strict=True):
            total += noise_scatter(robot, d.part, r, p, solution.weights, turn, noise, a.log.period)
        return total

    return equations.solve(scatter, solution.rank)


def _beyond(logs: Repeated, rows: list[Rows], p: np.ndarray, noise: dict[str, float]) -> list[np.ndarray]:
    """Per log and frequency of the transform: share of the residual's amplitude that no sensor's noise is.

    A hinge that the controller shakes with the encoders' noise rings between the samples; near reversals
    friction changes its sign with the noise. Both are motion, which no noise of a sensor tells of.
    """
    rng, out = np.random.default_rng(0), []
    for d, r, a in zip(logs.data, rows, logs.again, strict=True):
        more = in_memory(logs.robot, condition(a.log.noisier(noise, rng), logs.robot))
        change = (more.y - d.y) - (predicted(more.A, p) - predicted(d.A, p))
        out.append(beyond_noise(*(smoothed_power(v * r.share) for v in (r.residual(p), change))))
    return out


def ringing(robot: Robot, motions: Sequence[Motion], period: float) -> list[str]:
    """Dampings of the hinges that vibrate faster than logs of this period can follow; robot: fitted."""
    limit = _FASTEST / (2 * period)
    fast = {c for motion in motions for c, f in natural_frequencies(robot, motion).items() if f > limit}
    return sorted(c.replace(".eps[", ".d[") for c in fast)


def without_intervals_of(solution: Solution, columns: Sequence[str], names: Sequence[str]) -> Solution:
    """The solution without the covariance of the named parameters."""
    covariance = solution.covariance.copy()
    told = [columns.index(name) for name in names]
    covariance[told, :] = covariance[:, told] = np.nan
    return replace(solution, covariance=covariance)
